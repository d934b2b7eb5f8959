"""Benchmarks that start processes, and those that run hundreds of missions."""

from __future__ import annotations

from benchmarks.harness.benchmark import FOLDER, Aim, Benchmark, Figure, Target

NOTHING = Target(Aim.AT_MOST, must=0)
ONE_SEARCH = "--seeds 1 --budget 1 --strategies random --only 'tries once'"
ONE_RUN = "--seeds 1 --worlds explore_arena --strategies random --seconds 2"
HALF = Target(Aim.OF_OLD, must=0.5)
ONE_LEG = "--mission benchmarks/short.yaml --legs 0"

COMMANDS = (
    Benchmark(
        "start",
        "how soon a command starts: first line, first step, --help, and without its virtual work",
        ("start.py --rounds {rounds}",),
        ("start.py --rounds 1",),
        (
            Figure(
                "square.yaml --json less its virtual work",
                Target(Aim.OF_OLD, must=0.8, aim=0.5),
                "`run square.yaml --json`, less its virtual work",
            ),
            Figure("square.yaml --json, whole process, CPU"),
            Figure(
                "first line on a terminal",
                Target(Aim.AT_MOST, must=0.3),
                "`run explore.yaml`, first line on a terminal",
            ),
            Figure(
                "mission and world are named",
                Target(Aim.AT_MOST, must=0.3),
                "`run explore.yaml`, mission and world named",
            ),
            Figure("first step", Target(Aim.AT_MOST, must=0.7), "`run explore.yaml`, first step"),
            Figure("--help", Target(Aim.AT_MOST, must=0.1), "`--help`"),
            Figure("run --help", Target(Aim.AT_MOST, must=0.1), "`run --help`"),
            Figure("completion*", Target(Aim.AT_MOST, must=0.1), "completion"),
        ),
        rounds=7,
        takes="half a minute",
    ),
    Benchmark(
        "live",
        "simulator, servers and executive as processes at 1 x real time: CPU of each",
        ("live.py --rounds {rounds}",),
        ("live.py --rounds 1 --seconds 0.5 --settle 0",),
        (Figure("*, CPU at 1 x real time", HALF, "live mode, of one processor"),),
        rounds=3,
        takes="a minute",
    ),
    Benchmark(
        "watching",
        "what `watch` costs a mission, and how fast its view is on a tree of 10,000 nodes",
        ("watching.py --turns {rounds}",),
        ("watching.py --turns 1 --nodes 100 --changes 2 --only picture",),
        (
            Figure("watch: slow-down", optional=True),
            Figure("watch --json: slow-down", optional=True),
            Figure("first picture of a large tree"),
            Figure("a change of a large tree"),
        ),
        rounds=5,
        takes="two minutes",
    ),
    Benchmark(
        "web",
        "from a change to its paint in a browser, and what pages cost the mission",
        ("web.py --rounds {rounds}",),
        ("web.py benchmarks/short.yaml --rounds 1 --changes 2 --brief",),
        (
            Figure("change to paint", Target(Aim.AT_MOST, must=100), optional=True),
            Figure("*: CPU with a page to without", optional=True),
        ),
        rounds=3,
        takes="three minutes; with Chromium only",
    ),
    Benchmark(
        "loading",
        "loading and checking a mission of 1,000 to 10,000 nodes",
        ("loading.py --rounds {rounds}",),
        ("executive.py --only loading --rounds 1 --nodes 1000",),
        (Figure("* nodes: load and check"),),
        rounds=7,
    ),
    Benchmark(
        "resume",
        "a mission killed at 200 random instants and resumed, as processes; resumable",
        ("../campaigns/resume.py --results resume.jsonl",),
        (f"../campaigns/resume.py --count 1 --results {FOLDER}/resume.jsonl",),
        (Figure("findings", NOTHING),),
        takes="an hour",
    ),
    Benchmark(
        "floods",
        "floods of requests and messages: is control on time, what do they cost",
        ("../campaigns/floods.py",),
        ("../campaigns/floods.py --only servers --count 2 --pauses 0.02 --kinds waits",),
        (Figure("*: CPU"), Figure("*: a command is late by", optional=True)),
        takes="ten minutes",
    ),
)

CAMPAIGNS = (
    Benchmark(
        "sweeps",
        "scenarios a second on all workers, against loops in one process",
        ("sweeps.py rate --rounds {rounds}",),
        (f"sweeps.py rate --rounds 1 --count 1 --workers 1 {ONE_LEG}",),
        (
            Figure("rate to that of loops in one process", Target(Aim.AT_LEAST, must=0.9)),
            Figure(
                "share of a worker's time that is not a scenario's own",
                Target(Aim.AT_MOST, must=0.02),
            ),
        ),
        rounds=3,
        takes="ten minutes",
    ),
    Benchmark(
        "sweep-memory",
        "memory of client and workers while 10,000 scenarios go by",
        ("sweeps.py memory",),
        ("sweeps.py memory --count 3 --after 1 --workers 1",),
        (Figure("growth of memory", Target(Aim.AT_MOST, must=1.05)),),
        takes="an hour",
    ),
    Benchmark(
        "sweep-kills",
        "sweeps whose processes are killed at random: is a row lost, doubled or another?",
        ("sweeps.py kills --rounds {rounds}",),
        ("sweeps.py kills --rounds 1 --count 2 --most-kills 0",),
        (Figure("rounds with lost, doubled or different rows", NOTHING),),
        rounds=20,
        takes="half an hour",
    ),
    Benchmark(
        "sweep-resume",
        "how soon a sweep of 100,000 scenarios knows what is left of it",
        ("sweeps.py resume --rounds {rounds}",),
        ("sweeps.py resume --rounds 1 --count 10",),
        (Figure("what is left of a sweep is known after", Target(Aim.AT_MOST, must=5)),),
        rounds=3,
    ),
    Benchmark(
        "sweep-report",
        "the page, the table and the CSV of a sweep of 100,000 rows",
        ("sweep_report.py",),
        ("sweep_report.py --rows 10",),
        (Figure("rows and page, CPU"), Figure("size of the page"), Figure("peak memory")),
    ),
    Benchmark(
        "search",
        "runs until `falsify` finds each of 60 planted defects, by every strategy; resumable",
        ("../campaigns/search.py search.jsonl",),
        (f"../campaigns/search.py {FOLDER}/search.jsonl {ONE_SEARCH}",),
        (Figure("runs until found"),),
        takes="an hour",
    ),
    Benchmark(
        "coverage",
        "how fast each strategy explores a world; 160 runs of three virtual minutes",
        ("coverage.py --only-runs",),
        (f"coverage.py --only-runs --runs {FOLDER}/runs.jsonl {ONE_RUN}",),
        (Figure("*: floor that is known after three minutes"),),
        takes="twenty minutes",
    ),
    Benchmark(
        "campaign",
        "10,000 drawn missions with faults on the stage: hangs, tracebacks, goals left, collisions",
        ("../campaigns/campaign.py",),
        ("../campaigns/campaign.py --count 2 --jobs 1 --results {folder}/campaign.jsonl",),
        (Figure("findings", NOTHING),),
        takes="hours",
    ),
    Benchmark(
        "attached-campaign",
        "200 attached missions whose processes are killed, stopped and restarted",
        ("../campaigns/attached_campaign.py",),
        ("../campaigns/attached_campaign.py --only 2 --jobs 1 --results {folder}/attached.jsonl",),
        (Figure("findings", NOTHING),),
        takes="hours",
    ),
)

SAFETY = (
    Benchmark(
        "safety-drives",
        "drives at walls and appearing obstacles: collisions, what is left of the distance",
        ("../campaigns/safety.py --only drives --no-page",),
        ("../campaigns/safety.py --only drives --no-page --poses 1",),
        (Figure("collisions of drives", NOTHING), Figure("left of the stopping distance")),
        takes="ten minutes",
    ),
    Benchmark(
        "safety-movers",
        "explorations among obstacles that move: what the robot does when one meets it",
        ("../campaigns/safety.py --only movers --no-page",),
        ("../campaigns/safety.py --only movers --no-page --outings 1 --seconds 2",),
        (Figure("*: contacts with movers"), Figure("*: driven into a mover")),
        takes="half an hour",
    ),
    Benchmark(
        "safety-stops",
        "every action stopped by the service and by a lost scan: how soon the base stands",
        ("../campaigns/safety.py --only stops --no-page",),
        ("../campaigns/safety.py --only stops --no-page",),
        (Figure("stands after a stop or a lost scan", Target(Aim.AT_MOST, must=1)),),
        takes="seconds",
    ),
    Benchmark(
        "safety-kills",
        "servers and executive killed while the robot drives: how soon the base stands",
        ("../campaigns/safety.py --only kills --no-page",),
        (
            "../campaigns/safety.py --only kills --no-page --kills 1"
            " --killed servers --behind nothing",
        ),
        (Figure("stands after killed *", Target(Aim.AT_MOST, must=0.5)),),
        takes="five minutes",
    ),
    Benchmark(
        "safety-alarms",
        "attached missions on a busy machine: is a living executive taken for dead?",
        ("../campaigns/safety.py --only alarms --no-page --results {folder}/alarms.jsonl",),
        (
            "../campaigns/safety.py --only alarms --no-page --alarms 1 --busy 0"
            " --results {folder}/alarms.jsonl",
        ),
        (Figure("given up on a busy machine", NOTHING),),
        takes="half an hour",
    ),
)
