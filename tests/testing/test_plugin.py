"""The plugin is there wherever the package is, and says what happened when a test fails."""

from __future__ import annotations

import subprocess
import sys

import pytest

import bt_mission.testing.stages  # noqa: F401 - NumPy cannot be imported anew by each inner session

FAILS = '''
MISSION = """
mission: waits
tree: {wait: 0.1}
"""

def test_it_waits(stage):
    run = stage.run(MISSION, seed=4)
    run.until_done()
    assert run.check("always time < 0.1")

def test_it_waits_on(stage):
    assert stage.run(MISSION).until_done().status == "success"
'''


def test_a_test_that_fails_shows_its_run(pytester: pytest.Pytester) -> None:
    """What the check read, seed, time, tree and events; the next test has a fresh stage."""
    pytester.makepyfile(FAILS)
    result = pytester.runpytest("-p", "no:cacheprovider")
    result.assert_outcomes(passed=1, failed=1)
    result.stdout.fnmatch_lines(
        [
            "E  *assert <violated by 0.05 s at 0.15 s, first at 0.10 s: time = 0.1>",
            "*- mission -*",
            "waits: success, at 0.15 s, seed 4",
            "✓ wait  0.0 s left",
            "last events:",
            "*mission ended: success",
            "always time < 0.1: violated by 0.05 s at 0.15 s, first at 0.10 s: time = 0.1",
            "▶ wait",
        ]
    )


def test_a_test_whose_mission_violates_a_requirement_fails_once(pytester: pytest.Pytester) -> None:
    """It is one failure, not a passed test with an error; after its own failure, it is that."""
    pytester.makepyfile(
        """
        MISSION = "mission: m\\nrequirements: {rests: always time < 0.1}\\ntree: {wait: 0.3}\\n"

        def test_it(stage):
            stage.run(MISSION).until_done()

        def test_it_fails(stage):
            stage.run(MISSION).until_done()
            assert False

        def test_it_is_left(stage):
            stage.run(MISSION).advance(0.2)
        """
    )
    result = pytester.runpytest("-p", "no:cacheprovider")
    result.assert_outcomes(failed=3)
    result.stdout.fnmatch_lines(["test_*FFF*", "requirements failed: rests: violated*"])


@pytest.mark.process
def test_the_plugin_costs_next_to_nothing_where_there_is_no_mission() -> None:
    """It is loaded in every session of its environment: no ROS, no MuJoCo, no mission language."""
    code = (
        "import pytest, sys\n"
        "before = set(sys.modules)\n"
        "import bt_mission.testing.plugin\n"
        "new = set(sys.modules) - before\n"
        "print(*sorted(n for n in new if n.partition('.')[0] != 'bt_mission'))\n"
        "print(*sorted(n for n in sys.modules if n.startswith('bt_mission')))\n"
    )
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    others, ours = done.stdout.splitlines()
    assert others == ""
    assert ours.split() == [
        "bt_mission",
        "bt_mission.base",
        "bt_mission.base.commands",
        "bt_mission.base.entry_points",
        "bt_mission.base.lazy",
        "bt_mission.base.text",
        "bt_mission.testing",
        "bt_mission.testing.options",
        "bt_mission.testing.plugin",
        "bt_mission.testing.results",
        "bt_mission.testing.seed_hooks",
    ]


UNTESTED = """
    MISSION = "mission: waits\\ntree: {wait: 0.2}\\n"

    def test_never_moved(stage):
        stage.run(MISSION)

    def test_at(stage):
        run = stage.run(MISSION)
        run.at(500, lambda run: None)
        run.until_done()

    def test_when(stage):
        run = stage.run(MISSION)
        run.when(lambda s: s.t > 500, stage.spawn_box(at=(1, 0)))
        run.until_done()

    def test_box(stage):
        run = stage.run(MISSION)
        stage.spawn_box(at=(1, 0))
        run.until_done()

    def test_server(stage, scripted_server):
        scripted_server("turn")
        stage.run(MISSION).until_done()

    def test_plan(stage):
        run = stage.run(MISSION)
        stage.plan(run, "at 500: drop scan")
        run.until_done()

    def test_allowed(stage, scripted_server):
        scripted_server("turn", may_not_be_asked=True)
        run = stage.run(MISSION)
        run.at(500, lambda run: None, may_not_happen=True)
        run.when(lambda s: s.t > 500, stage.spawn_box(at=(1, 0)), may_not_happen=True)
        stage.plan(run, "at 500: drop scan may_not_happen")
        run.do(stage.spawn_box(at=(1, 0)))
        run.until_done()
"""


def test_a_test_that_has_not_tested_fails(pytester: pytest.Pytester) -> None:
    """Each says what has not happened; what a test allows does not fail it."""
    pytester.makepyfile(UNTESTED)
    result = pytester.runpytest()
    result.assert_outcomes(passed=1, failed=6)
    result.stdout.fnmatch_lines(
        [
            "not tested: the run of 'waits' was never moved: call run.until_done()",
            "not tested: run.at(500, ...) never happened: the run was over at 0.25 s",
            "not tested: run.when(...) never happened: the run was over at 0.25 s",
            "not tested: faults.spawn_box(*) was never begun: pass it to run.do, *",
            "not tested: the scripted server of /turn got no goal: remove it, or allow it by *",
            "not tested: fault at 500.0: drop scan: never happened, the mission ended at 0.25 s",
        ]
    )


UNREAD = """
    MISSION = "mission: waits\\nworld: empty_arena\\ntree: {wait: 0.2}\\n"

    def test_bare(stage):
        run = stage.run(MISSION)
        run.until_done()
        run.check("always x > 5")

    def test_holds(stage):
        run = stage.run(MISSION)
        run.until_done()
        run.check("always x < 5")

    def test_read(stage):
        run = stage.run(MISSION)
        run.until_done()
        assert not run.check("always x > 5")
        assert run.check("always x > 6").t == 0.05
        verdict = run.check("always x > 7")
        assert "violated" in verdict.line
"""


def test_a_check_that_nobody_reads_fails_where_it_does_not_hold(pytester: pytest.Pytester) -> None:
    """A test without `assert` would pass whatever happens."""
    pytester.makepyfile(UNREAD)
    result = pytester.runpytest()
    result.assert_outcomes(passed=2, failed=1)
    result.stdout.fnmatch_lines(
        ["not asserted: the result of run.check('always x > 5') is not used, and it is: violated*"]
    )
