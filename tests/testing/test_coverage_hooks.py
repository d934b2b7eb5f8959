"""``--mission-cov``, as somebody sees it who runs pytest."""

from __future__ import annotations

import json

import pytest

LIBRARY = """
trees:
  turn_or_rest:
    needs: {turns: bool}
    do:
      fallback:
        - check: turns
        - wait: 0.1
"""
MISSION = """
mission: {name}
include: [library.yaml]
inputs: {{turns: {turns}}}
tree:
  sequence:
    - tree: {{name: turn_or_rest, inputs: {{turns: $turns}}}}
    - when: turns
      do: {{log: turned}}
"""
TESTS = '''
import pytest

TEXT = """
mission: short
tree: {wait: %s}
"""

@pytest.mark.parametrize("name", ["turning", "resting"])
def test_it(stage, name):
    assert stage.run(f"missions/{name}.yaml").until_done().status == "success"

@pytest.mark.parametrize("seconds", [0.1, 0.2])
def test_text(stage, seconds, tmp_path):
    stage.run(TEXT % seconds).until_done()
    file = tmp_path / "short.yaml"
    file.write_text(TEXT % seconds)
    stage.run(file).until_done()
'''


@pytest.fixture
def missions(pytester: pytest.Pytester) -> pytest.Pytester:
    """Two missions that share a tree, one that no test runs, and one in a test."""
    folder = pytester.mkdir("missions")
    (folder / "library.yaml").write_text(LIBRARY)
    for name, turns in (("turning", "true"), ("resting", "false"), ("unused", "true")):
        (folder / f"{name}.yaml").write_text(MISSION.format(name=name, turns=turns))
    pytester.makepyfile(test_a=TESTS)
    return pytester


TABLE = [
    "*= coverage of missions =*",
    "missions  *",
    "missions/library.yaml      3        3         4     4         2      2   100%",
    "missions/resting.yaml      4        3         4     3         2      1    70%  9",
    "missions/turning.yaml      4        4         4     4         2      1    90%",
    "test_a.py 'short'          1        1         1     1         0      0   100%",
    "in all                    12       11        13    12         6      4    87%",
    "missions/resting.yaml",
    "     6  resting",
    "     8    when turns  never: true",
    "     9      log       never reached",
]


@pytest.mark.thorough
@pytest.mark.parametrize(
    "workers",
    [
        pytest.param((), marks=pytest.mark.thorough),  # the workers do the same, and add it up
        pytest.param(("-n", "2"), marks=pytest.mark.process),
    ],
    ids=["one", "xdist"],
)
def test_tests_missions_and_workers_add_up(missions, workers):
    """A shared tree counts where it is written; texts count under their test file."""
    reports = [f"--mission-cov-report=out/cov.{kind}" for kind in ("txt", "json", "html")]
    run = missions.runpytest_subprocess if workers else missions.runpytest
    result = run("--mission-cov", *reports, *workers)
    result.assert_outcomes(passed=4)
    result.stdout.fnmatch_lines([*TABLE, "written to out/cov.txt, out/cov.json, out/cov.html"])
    assert "missions/turning.yaml" in (missions.path / "out/cov.txt").read_text()
    assert "<h2" in (missions.path / "out/cov.html").read_text()
    files = json.loads((missions.path / "out/cov.json").read_text())["files"]
    assert files["missions/library.yaml"]["missions"] == ["resting", "turning"]
    assert files["missions/library.yaml"]["nodes"][1]["outcomes"] == {"true": 1, "false": 1}
    assert files["test_a.py 'short'"]["nodes"][0]["runs"] == 4


def test_missions_that_no_test_runs_count_where_that_is_asked_for(missions):
    """A file that is no mission is named."""
    result = missions.runpytest("--mission-cov-source=missions", "-k", "resting")
    result.assert_outcomes(passed=1, deselected=3)
    result.stdout.fnmatch_lines(
        [
            "missions/unused.yaml *  0%  6-9",
            "     6  unused  never reached",
            "not counted: missions/library.yaml:*",
        ]
    )


@pytest.mark.thorough
def test_missions_that_a_test_starts_by_itself_count(missions):
    """On a stage of its own, or on a node of its own that it spins."""
    missions.makepyfile(
        test_b="""
import rclpy

import bt_mission

def test_a_stage(tmp_path):
    mission = bt_mission.load("missions/turning.yaml")
    with bt_mission.Stage(mission, image_folder=tmp_path) as stage:
        while not stage.is_done:
            stage.step()

def test_a_runner():
    context = rclpy.Context()
    rclpy.init(context=context)
    node = rclpy.create_node("own", context=context)
    executor = rclpy.executors.SingleThreadedExecutor(context=context)
    executor.add_node(node)
    mission = bt_mission.load("missions/resting.yaml")
    with bt_mission.MissionRunner(node, mission) as runner:
        while not runner.is_done:
            executor.spin_once(timeout_sec=0.1)
    node.destroy_node()
    context.shutdown()
"""
    )
    result = missions.runpytest_subprocess("--mission-cov", "test_b.py")
    result.assert_outcomes(passed=2)
    result.stdout.fnmatch_lines(["*missions/turning.yaml*"])
    result.stdout.fnmatch_lines(["*missions/resting.yaml*"])


@pytest.mark.thorough
def test_too_little_fails_the_session(missions):
    """With the figures."""
    result = missions.runpytest("--mission-cov-fail-under=90")
    assert result.ret == 1
    result.stdout.fnmatch_lines(["FAILED: coverage of missions is 87.10%, below 90%"])
    assert missions.runpytest("--mission-cov-fail-under=80").ret == 0


def test_no_mission_is_too_little(pytester):
    """Nothing was proved."""
    pytester.makepyfile("def test_nothing(): pass")
    result = pytester.runpytest("--mission-cov-fail-under=10")
    assert result.ret == 1
    result.stdout.fnmatch_lines(["no mission was run in this process or its workers"])


@pytest.mark.parametrize(
    ("option", "words"),
    [
        ("--mission-cov-report=cov.pdf", "*: cov.pdf must end in one of .json, *"),
        ("--mission-cov-fail-under=all", "*expected a number from 0 to 100, got 'all'"),
    ],
)
def test_a_bad_option_is_refused(pytester, option, words):
    """Before anything runs."""
    result = pytester.runpytest(option)
    assert result.ret == 4
    result.stderr.fnmatch_lines([words])


def test_nothing_is_watched_without_being_asked(missions):
    """And not after a session that was asked."""
    missions.runpytest("--mission-cov", "-k", "resting").stdout.fnmatch_lines(
        ["*coverage of missions*"]
    )
    missions.runpytest("-k", "resting").stdout.no_fnmatch_line("*coverage of missions*")
