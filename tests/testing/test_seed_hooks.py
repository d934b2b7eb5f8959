"""Tests marked ``scenario``, as somebody sees them who runs pytest."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET

import pytest

TESTS = """
import pytest

BAD = {bad}

@pytest.mark.scenario(seeds=10, at_least=0.8)
def test_most(seed):
    assert seed not in BAD

@pytest.mark.scenario(seeds=range(3, 5))
@pytest.mark.parametrize("robot", ["waffle", "burger"])
class TestAll:
    def test_it(self, robot, seed):
        assert seed != 4 or robot != "burger"
"""
MISSION = '''
import pytest

MISSION = """
mission: waits
seed: 1
tree: {wait: "uniform(0, 10)"}
"""

@pytest.mark.scenario(seeds=[5, 6])
def test_takes_it(stage, mission, request):
    for what in (MISSION, mission(MISSION)):
        run = stage.run(what)
        run.until_done()
        assert run.mission.seed == request.node.callspec.params["seed"]

@pytest.mark.scenario(seeds=[5])
def test_has_its_own(stage):
    run = stage.run(MISSION, seed=0)
    run.until_done()
    assert run.mission.seed == 0

def test_has_none(stage):
    run = stage.run(MISSION)
    run.until_done()
    assert run.mission.seed == 1
'''


@pytest.fixture
def scenarios(pytester: pytest.Pytester):
    """Run the tests above with seeds that fail."""

    def run(*arguments: str, bad: object = (), own_process: bool = False) -> pytest.RunResult:
        pytester.makepyfile(test_a=TESTS.format(bad=repr(bad)))
        if own_process:
            return pytester.runpytest_subprocess(*arguments)
        return pytester.runpytest(*arguments)

    return run


def order(result: pytest.RunResult) -> list[str]:
    """The tests in the order in which they ran, by ``-v``."""
    return [line.split()[0] for line in result.outlines if "::" in line and "%]" in line]


def test_a_test_runs_once_for_each_seed(scenarios):
    """Beside its other parameters; a rate is told for each of them."""
    result = scenarios()
    result.assert_outcomes(passed=13, failed=1)
    result.stdout.fnmatch_lines(
        [
            "*- to repeat it -*",
            "pytest 'test_a.py::TestAll::test_it[[]*seed4*[]]'",
            "*= scenarios: seeds that passed, as a rate with its 95 % interval =*",
            "test_a.py::TestAll::test_it[[]burger[]]  1 of 2 passed: 0.500 (0.095 to 0.905)",
            "  seed 4: AssertionError:*",
            "    pytest 'test_a.py::TestAll::test_it[[]*seed4*[]]'",
            "test_a.py::TestAll::test_it[[]waffle[]]  2 of 2 passed: 1.000 (0.342 to 1.000)",
            "test_a.py::test_most * 10 of 10 passed: 1.000 (0.722 to 1.000), at least 0.8 wanted",
        ]
    )


def test_some_seeds_may_fail(scenarios):
    """They are expected failures; the session succeeds."""
    result = scenarios("-k", "most", bad=(2, 5))
    result.assert_outcomes(passed=8, xfailed=2)
    assert result.ret == 0
    result.stdout.fnmatch_lines(
        [
            "test_a.py::test_most  8 of 10 passed: 0.800 *",
            "  2 seeds: 2, 5: *",
            "    pytest 'test_a.py::test_most[[]seed2*",
        ]
    )


@pytest.mark.thorough
@pytest.mark.parametrize(
    "workers",
    [
        pytest.param((), marks=pytest.mark.thorough),  # the workers do the same, and it is counted
        pytest.param(("-n", "2"), marks=pytest.mark.process),
    ],
    ids=["one", "xdist"],
)
def test_too_few_seeds_fail_the_test_as_a_whole(scenarios, pytester, workers):
    """Its reports are shown then, in JUnit's file, too; pytest ends with 1."""
    options = ("-k", "most", "--junitxml=junit.xml", *workers)
    result = scenarios(*options, bad=(2, 5, 7), own_process=bool(workers))
    result.assert_outcomes(passed=7, xfailed=3, failed=1)
    assert result.ret == 1
    result.stdout.fnmatch_lines(
        [
            "*_ test_most _*",
            "7 of 10 passed: 0.700 (0.397 to 0.892), at least 0.8 wanted",
            "-* seed 2 -*",
            ">*assert seed not in BAD",
            "FAILED test_a.py::test_most - 7 of 10 passed*",
        ]
    )
    cases = ET.parse(pytester.path / "junit.xml").iter("testcase")  # noqa: S314 - our own
    (whole,) = (case for case in cases if case.get("name") == "test_most")
    assert whole.find("failure") is not None
    percents = [int(text) for text in re.findall(r"\[ *(\d+)%\]", result.stdout.str())]
    assert max(percents) == 100
    result = scenarios("-v", "-k", "most")
    assert [name[-7:] for name in order(result)[:4]] == ["[seed2]", "[seed5]", "[seed7]", "[seed0]"]


@pytest.mark.thorough
def test_seeds_that_failed_run_first_until_they_pass(scenarios):
    """Also those that the test itself does not name."""
    scenarios("-k", "most", "--scenario-seeds=30", bad=(7, 22))
    result = scenarios("-k", "most", "-v", bad=(22,))
    result.assert_outcomes(passed=10, xfailed=1)
    assert [name[-7:-1] for name in order(result)[:3]] == ["[seed7", "seed22", "[seed0"]
    result = scenarios("-k", "most", "-v")
    assert [name[-7:-1] for name in order(result)[:2]] == ["seed22", "[seed0"]
    result = scenarios("-k", "most", "-v")
    assert [name[-7:-1] for name in order(result)[:2]] == ["[seed0", "[seed1"]


def test_last_failed_knows_the_seeds_that_failed(scenarios):
    """``--lf`` after a rate that was not reached."""
    scenarios("-k", "most", bad=(2, 5, 7))
    result = scenarios("-v", "--lf", bad=(2,))
    assert [name[-7:] for name in order(result)][:3] == ["[seed2]", "[seed5]", "[seed7]"]


def test_the_line_that_repeats_a_failure_repeats_it(scenarios, pytester):
    """Where nothing is remembered, and the seed is none of the test's own."""
    scenarios()
    result = pytester.runpytest("-p", "no:cacheprovider", "test_a.py::test_most[seed734]")
    result.assert_outcomes(passed=1)


def test_another_number_of_seeds(scenarios):
    """By the command line."""
    result = scenarios("--scenario-seeds=2")
    result.assert_outcomes(passed=5, failed=1)
    result = scenarios("--scenario-seeds=none")
    result.stderr.fnmatch_lines(["*expected a number of seeds from 1, got 'none'"])


@pytest.mark.parametrize(
    ("mark", "words"),
    [
        ("scenario(seeds=0)", "@pytest.mark.scenario: seeds=0: at least one seed is needed"),
        (
            "scenario(seeds=2)\n@pytest.mark.parametrize('a,seed', [(1, 2)])",
            "@pytest.mark.scenario gives the argument 'seed', and so does parametrize",
        ),
    ],
)
def test_a_bad_marker_stops_the_collection(pytester, mark, words):
    """Without a traceback."""
    pytester.makepyfile(test_a=f"import pytest\n@pytest.mark.{mark}\ndef test_x(a, seed): pass\n")
    result = pytester.runpytest()
    assert result.ret == 2
    result.stdout.fnmatch_lines([f"test_a.py::test_x: {words}*"])
    result.stdout.no_fnmatch_line("*Traceback*")


@pytest.mark.thorough
def test_the_stage_takes_the_seed(pytester):
    """Unless the test gives one; missions that are made before take it, too."""
    pytester.makepyfile(MISSION)
    pytester.runpytest().assert_outcomes(passed=4)


IDENTICAL = '''
import pytest

from tests.support.thorough import sample

@pytest.mark.scenario(seeds=3)
def test_waits(stage):
    stage.run("""
        mission: waits
        tree: {wait: 1}
        """).until_done()

@pytest.mark.scenario(seeds=1, at_least=0.5)
def test_has_the_usual_nature(stage):
    run = stage.run("sweep")
    run.step()
    assert run.stage.runs[0].nature["lidar_noise"] > 0

@pytest.mark.scenario(seeds=1, at_least=0.5)
def test_has_the_nature_that_it_asks_for(stage):
    run = stage.run("sweep", nature="none")
    run.step()
    assert run.stage.runs[0].nature == {}

@pytest.mark.scenario(seeds=2)
def test_chooses(stage):
    stage.run("""
        mission: chooses
        tree: {wait: "uniform(1, 2)"}
        """).until_done()
'''


@pytest.mark.thorough
def test_seeds_that_change_nothing_are_one_sample(pytester):
    """What the seed decides alone, such as ids of goals, does not make runs distinct."""
    pytester.makepyfile(IDENTICAL)
    result = pytester.runpytest()
    result.assert_outcomes(passed=7)
    result.stdout.fnmatch_lines(
        [
            "*::test_chooses *2 of 2 passed: 1.000 (0.342 to 1.000)",
            "*::test_waits * 3 of 3 passed: 1.000 (0.207 to 1.000); 3 runs, 1 distinct: *",
        ]
    )
