"""Benchmarks of missions on the stage, of the executive and of recordings."""

from __future__ import annotations

from benchmarks.harness.benchmark import Aim, Benchmark, Figure, Target

SHARE = Target(Aim.AT_LEAST, must=0.35, aim=0.5)
NOTHING = Target(Aim.AT_MOST, must=0)
LINEAR = Target(Aim.AT_MOST, must=15)

ON_THE_STAGE = (
    Benchmark(
        "speed",
        "a mission on the stage against bare mj_step of the same world with the same scans",
        (
            "speed.py benchmarks/explore_no_camera.yaml --rounds {rounds}",
            "speed.py missions/patrol.yaml --rounds {rounds}",
            "speed.py missions/explore_fixed.yaml --rounds {rounds}",
        ),
        ("speed.py benchmarks/short.yaml --rounds 1",),
        (
            Figure("*: share of bare mj_step and scans", SHARE, "share of bare `mj_step`"),
            Figure(
                "explore_no_camera: stage",
                Target(Aim.AT_LEAST, must=140, aim=200),
                "stage, explore without camera",
                optional=True,
            ),
            Figure("*: stage"),
            Figure("*: bare mj_step and scans"),
            Figure("*: CPU a virtual second", row="CPU a virtual second"),
        ),
        rounds=7,
    ),
    Benchmark(
        "shares",
        "where the time of a step goes, by samples of a run; for the chart",
        ("shares.py --rounds {rounds}",),
        ("shares.py benchmarks/short.yaml --rounds 1",),
        (Figure("a step, CPU"), Figure("*: CPU a step")),
        rounds=10,
        takes="half a minute",
    ),
    Benchmark(
        "scaling",
        "does a step cost in proportion: robots, obstacles, rays of the lidar, nodes of the tree",
        ("scaling.py --rounds {rounds}",),
        ("scaling.py --rounds 1 --seconds 0.1 --most 4",),
        (
            Figure("*: a step is beside the line by", LINEAR, "beside a straight line"),
            Figure("a * more, CPU a step", row="CPU of a step for one more"),
        ),
        rounds=3,
        takes="two minutes",
    ),
    Benchmark(
        "stage",
        "a fresh stage: made, stepped once and closed",
        ("stage.py --only fresh --rounds {rounds}",),
        ("stage.py --only fresh --rounds 1",),
        (Figure("a fresh stage", Target(Aim.AT_MOST, must=20), "a fresh stage"),),
        rounds=7,
        takes="seconds",
    ),
    Benchmark(
        "step",
        "a control step without physics, under our executor and under rclpy's",
        ("stage.py --only step --rounds {rounds}",),
        ("stage.py --only step --rounds 1",),
        (Figure("a step of the nodes, CPU"), Figure("the same to rclpy's executor")),
        rounds=7,
        takes="seconds",
    ),
    Benchmark(
        "calls",
        "the calls of a control step, counted by Python's profiler; the same on every machine",
        ("calls.py",),
        ("calls.py --seconds 1 2",),
        (
            Figure(
                "calls a control step",
                Target(Aim.AT_MOST, must=700, aim=500),
                "calls a control step",
            ),
            Figure("calls a control step of Python functions"),
        ),
        takes="seconds",
    ),
    Benchmark(
        "memory",
        "what a stage takes, and by how much it grows with virtual hours",
        ("stage.py --only memory",),
        ("stage.py --only memory --hours 0.001 --settle 1",),
        (Figure("memory of a stage"), Figure("growth of memory a virtual hour")),
        takes="two minutes",
    ),
    Benchmark(
        "scenarios",
        "drawn scenarios with faults one after the other, on one core",
        ("stage.py --only scenarios",),
        ("stage.py --only scenarios --count 1",),
        (Figure("virtual seconds a second"),),
    ),
    Benchmark(
        "pytest",
        "a hundred seeds of explore.yaml as tests, on two cores",
        ("stage.py --only pytest",),
        ("stage.py --only pytest --count 1 --workers 0",),
        (Figure("virtual seconds a second"), Figure("wall time of a test")),
    ),
    Benchmark(
        "image",
        "a camera image, and how many are drawn that nobody takes",
        ("image.py --rounds {rounds}",),
        ("image.py --rounds 1 --images 1",),
        (
            Figure(
                "an image 320x240", Target(Aim.OF_OLD, must=1.1), "a camera image 320x240, drawn"
            ),
            Figure("an image 320x240, CPU of the thread"),
            Figure("images drawn for each that is stored", row="images drawn for each stored one"),
            Figure("images drawn without a camera sweep", NOTHING, "images drawn for nobody"),
        ),
        rounds=7,
        takes="seconds",
    ),
    Benchmark(
        "legs",
        "how long the legs of explore.yaml are that a condition cuts at 2 m, by the true pose",
        ("legs.py",),
        ("legs.py --seeds 1",),
        (Figure("legs cut at 2 m"),),
    ),
    Benchmark(
        "determinism",
        "drawn scenarios, each twice in unlike processes: do traces differ?",
        ("../campaigns/determinism.py",),
        ("../campaigns/determinism.py --count 1",),
        (Figure("traces that differ", NOTHING),),
        takes="ten minutes",
    ),
)

EXECUTIVE = (
    Benchmark(
        "ticks",
        "a tick in which nothing changes, against py_trees with a tree of the same shape",
        ("executive.py --only ticks --only extras --rounds {rounds}",),
        ("executive.py --only ticks --only extras --rounds 1 --nodes 100",),
        (Figure("*: to py_trees"), Figure("*: a node")),
        rounds=5,
        takes="two minutes",
    ),
    Benchmark(
        "goals",
        "a goal through a leaf, against an action client alone",
        ("executive.py --only goals --rounds {rounds}",),
        ("executive.py --only goals --rounds 1",),
        (
            Figure(
                "a leaf to a bare client",
                Target(Aim.AT_MOST, must=1.25, aim=1.1),
                "a goal through a leaf to a bare client, CPU",
            ),
            Figure("a goal through a leaf, CPU"),
        ),
        rounds=9,
        takes="seconds",
    ),
    Benchmark(
        "halts",
        "a tick that halts 1, 10 or 100 running goals",
        ("executive.py --only halts --rounds {rounds}",),
        ("executive.py --only halts --rounds 1",),
        (Figure("halting * goals, CPU of each"),),
        rounds=9,
        takes="seconds",
    ),
)

RECORDINGS = (
    Benchmark(
        "recording",
        "what recording everything costs explore.yaml and patrol.yaml, and how large it is",
        ("recording.py --rounds {rounds}",),
        ("recording.py benchmarks/short.yaml --rounds 1",),
        (
            Figure(
                "*: CPU with a recording to without",
                Target(Aim.AT_MOST, must=1.12, aim=1.08),
                "recording everything, CPU to without",
            ),
            Figure("*: the same of whole runs"),
            Figure("*: size of a virtual minute"),
        ),
        rounds=7,
    ),
    Benchmark(
        "requirements",
        "what twenty requirements and one of the clearance cost explore.yaml and patrol.yaml",
        ("requirements.py --rounds {rounds}",),
        ("requirements.py benchmarks/short.yaml --rounds 1",),
        (Figure("*: * to without"),),
        rounds=5,
        takes="two minutes",
    ),
    Benchmark(
        "requirements-attached",
        "the same requirements on the stage and attached: do verdicts differ?",
        ("../campaigns/requirements_attached.py",),
        ("../campaigns/requirements_attached.py short",),
        (Figure("verdicts that differ", NOTHING),),
        takes="five minutes",
    ),
    Benchmark(
        "report",
        "reading a recording of ten minutes, and making its page",
        ("report.py --rounds {rounds}",),
        ("report.py --rounds 1 --mission benchmarks/short.yaml",),
        (Figure("read a recording, CPU"), Figure("make the page, CPU"), Figure("size of the page")),
        rounds=5,
        takes="half a minute",
    ),
    Benchmark(
        "replaying",
        "reading a recording of ten minutes, and going to any instant of it",
        ("replaying.py",),
        ("replaying.py --seeks 2 --mission benchmarks/short.yaml",),
        (Figure("read a recording, CPU"), Figure("go to any instant, CPU")),
        takes="half a minute",
    ),
    Benchmark(
        "forks",
        "forks without a change at random instants: byte-identical? And against a run",
        ("../campaigns/forks.py",),
        ("../campaigns/forks.py --count 1 --missions square",),
        (
            Figure("*: share that is byte-identical", Target(Aim.AT_LEAST, must=1)),
            Figure("*: fork to run, CPU", Target(Aim.AT_MOST, must=1.5)),
        ),
        takes="three minutes",
    ),
)
