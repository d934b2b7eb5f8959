"""What a test tells and leaves when it is over, as somebody sees it who runs pytest."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from bt_mission.base.errors import BtMissionError
from bt_mission.executive.stored_trace import read_trace
from bt_mission.recording.replay.timeline import read_timeline
from bt_mission.testing import failure_recording
from bt_mission.testing.results import folder_name

TESTS = '''
import pytest

MISSION = """
mission: waits
tree: {wait: 2}
"""

def test_passes(stage):
    stage.run(MISSION, seed=4).until_done()

def test_two(stage):
    for seed in (1, 2):
        stage.run(MISSION, seed=seed).until_done()
    assert not %(fails)s

@pytest.mark.scenario(seeds=[7], at_least=0.5)
def test_stops(stage):
    stage.run(MISSION).advance(0.5)
    assert not %(fails)s

def test_without():
    assert not %(fails)s
'''


@pytest.fixture
def session(pytester: pytest.Pytester):
    """Run the tests above."""

    def run(*arguments: str, fails: bool) -> pytest.RunResult:
        pytester.makepyfile(test_a=TESTS % {"fails": fails})
        return pytester.runpytest(*arguments)

    return run


def left_in(folder: Path) -> list[str]:
    """Every file in a folder, but for the one that git reads."""
    results = (path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())
    return sorted(path for path in results if path != ".gitignore")


def test_a_failed_test_leaves_its_traces(session, pytester):
    """Whole, with what to type; a test without runs leaves nothing."""
    result = session(fails=True)
    result.assert_outcomes(passed=1, failed=3, xfailed=1)
    result.stdout.fnmatch_lines(
        [
            "*- mission -*",
            "waits: success, at 2.05 s, seed 1",
            "*- to see it again -*",
            "bt-mission replay scenario_results/test_a.test_two/recording.mcap",
            "bt-mission replay scenario_results/test_a.test_two/recording_2.mcap",
        ]
    )
    folder = pytester.path / "scenario_results"
    assert left_in(folder) == [
        "test_a.test_stops-seed7/recording.mcap",
        "test_a.test_stops-seed7/run.txt",
        "test_a.test_stops-seed7/scenario.yaml",
        "test_a.test_stops-seed7/trace.jsonl",
        "test_a.test_two/recording.mcap",
        "test_a.test_two/recording_2.mcap",
        "test_a.test_two/run.txt",
        "test_a.test_two/run_2.txt",
        "test_a.test_two/scenario.yaml",
        "test_a.test_two/scenario_2.yaml",
        "test_a.test_two/trace.jsonl",
        "test_a.test_two/trace_2.jsonl",
    ]
    assert (folder / ".gitignore").read_text() == "*\n"
    trace = read_trace(folder / "test_a.test_stops-seed7/trace.jsonl")
    assert trace.start["seed"] == 7
    (end,) = (event for event in trace.events if event["event"] == "mission")
    assert end["reason"] == "its time is up", "what came after the failure is in it, too"
    assert "waits: interrupted" in (folder / "test_a.test_stops-seed7/run.txt").read_text()
    film = read_timeline(folder / "test_a.test_stops-seed7/recording.mcap")
    assert film.why_cut == ""
    assert json.dumps(end, sort_keys=True) in film.trace


@pytest.mark.thorough
def test_a_test_that_passes_takes_away_what_it_left(session, pytester):
    """Only its own: what another left stays until that passes."""
    session(fails=True)
    session("-k", "two", fails=False).assert_outcomes(passed=1, deselected=3)
    left = left_in(pytester.path / "scenario_results")
    assert {path.split("/")[0] for path in left} == {"test_a.test_stops-seed7"}


def test_runs_go_with_their_test(session, pytester):
    """Pytest itself keeps every test to the end of the session."""
    pytester.makeconftest(
        """
        from bt_mission.testing.results import STAGES

        def pytest_sessionfinish(session):
            print("kept:", [item.name for item in session.items if STAGES in item.stash])
        """
    )
    session("-s", fails=False).stdout.fnmatch_lines("*kept: []")


def test_the_folder_can_be_another(session, pytester):
    """From where pytest was started."""
    result = session("--scenario-results=out/here", "-k", "two", fails=True)
    result.stdout.fnmatch_lines(["bt-mission replay out/here/test_a.test_two/recording.mcap"])
    assert left_in(pytester.path / "out/here")


def test_a_folder_that_cannot_be_written_is_told(session, pytester):
    """The test's own failure is still shown."""
    (pytester.path / "file").write_text("no folder")
    result = session("--scenario-results=file", "-k", "two", fails=True)
    result.assert_outcomes(failed=1, deselected=3)
    result.stdout.fnmatch_lines(["it was not saved: */file/test_a.test_two: Not a directory"])


def test_a_goal_left_behind_fails_the_test_and_shows_the_run(pytester):
    """Its mission was interrupted with the test, and the server never confirmed the cancel."""
    pytester.makepyfile(
        test_a="""
        def test_it(stage, scripted_server):
            turn = scripted_server("turn", cancels=None)
            run = stage.run("mission: m\\ntree: {turn: {angle: 9}, timeout: 60}\\n")
            run.until(lambda s: turn.goals)
        """
    )
    result = pytester.runpytest()
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(
        [
            "*- mission -*",
            "m: interrupted*",
            "*replay scenario_results/test_a.test_it/recording.mcap",
        ]
    )
    result.stdout.fnmatch_lines(["orphaned goals: /turn goal ???????? of 'turn' (lost)"])


def recorded(pytester: pytest.Pytester) -> list[str]:
    """Every recording, wherever it is."""
    return sorted(path.parent.name for path in pytester.path.rglob("*.mcap"))


@pytest.mark.parametrize("where", ["option", "ini"])
def test_nothing_is_recorded_where_nobody_wants_it(session, pytester, where):
    """The trace is left as ever."""
    if where == "ini":
        pytester.makeini("[pytest]\nmission_record = off\n")
    arguments = ["--mission-record=off"] if where == "option" else []
    result = session(*arguments, "-k", "stops", fails=True)
    result.assert_outcomes(failed=1, xfailed=1, deselected=3)
    result.stdout.fnmatch_lines(
        ["bt-mission replay scenario_results/test_a.test_stops-seed7/trace.jsonl"]
    )
    assert recorded(pytester) == []


@pytest.mark.thorough
def test_tests_that_pass_leave_their_recordings_where_all_are_wanted(session, pytester):
    """The option outdoes the ini file; a test without runs leaves nothing."""
    pytester.makeini("[pytest]\nmission_record = off\n")
    session("--mission-record=all", fails=False).assert_outcomes(passed=4)
    left = recorded(pytester)
    assert left == ["test_a.test_passes", "test_a.test_stops-seed7", *["test_a.test_two"] * 2]


@pytest.mark.thorough
def test_tests_that_pass_leave_no_recording(session, pytester):
    """Not in pytest's own folders either."""
    session("--basetemp=temp", fails=False).assert_outcomes(passed=4)
    assert recorded(pytester) == []


@pytest.mark.thorough
def test_of_many_runs_the_last_are_recorded(pytester):
    """Those that are told of."""
    pytester.makepyfile(
        test_a="""
        def test_many(stage):
            for seed in range(7):
                stage.run("mission: m\\ntree: {wait: 0.1}\\n", seed=seed).until_done()
            assert 0
        """
    )
    pytester.runpytest("--basetemp=temp").assert_outcomes(failed=1)
    left = [path for path in left_in(pytester.path / "scenario_results") if "mcap" in path]
    names = ["recording", *(f"recording_{number}" for number in range(2, 6))]
    assert left == [f"test_a.test_many/{name}.mcap" for name in names]
    seeds = [
        json.loads(read_timeline(pytester.path / "scenario_results" / path).trace[1])["seed"]
        for path in left
    ]
    assert seeds == [2, 3, 4, 5, 6]


def test_a_recording_that_fails_fails_no_test(session, pytester, monkeypatch):
    """What is missing is said where it would be replayed."""

    def full(*_: object) -> None:
        raise BtMissionError("run.mcap: cannot write the recording: No space left on device")

    monkeypatch.setattr(failure_recording, "RunRecorder", full)
    session("-k", "passes", fails=False).assert_outcomes(passed=1, deselected=3)
    result = session("-k", "two", fails=True)
    result.stdout.fnmatch_lines(
        [
            "bt-mission replay scenario_results/test_a.test_two/trace.jsonl",
            "  the recording lacks run.mcap: cannot write the recording: No space left on device",
        ]
    )


def test_what_is_recorded_is_one_of_three(session, pytester):
    """It says which."""
    pytester.makeini("[pytest]\nmission_record = some\n")
    result = session(fails=False)
    result.stderr.fnmatch_lines(["*mission_record: expected one of off, failed, all, got 'some'*"])


@pytest.mark.thorough
def test_junit_has_the_figures(session, pytester):
    """Virtual and wall time, seed and trace of each run; of a test without runs nothing."""
    session("--junitxml=junit.xml", fails=False)
    cases = {
        case.get("name"): [
            (element.get("name"), element.get("value")) for element in case.iter("property")
        ]
        for case in ET.parse(pytester.path / "junit.xml").iter("testcase")  # noqa: S314 - ours
    }
    names = [name for name, _ in cases["test_two"]]
    assert names == ["virtual_s", "wall_s", "seed", "trace_sha256", "seed", "trace_sha256"]
    assert dict(cases["test_two"])["virtual_s"] == "4.1"
    result = dict(cases["test_passes"])
    assert result["seed"] == "4"
    assert len(str(result["trace_sha256"])) == 64
    assert float(str(result["wall_s"])) > 0
    assert cases["test_without"] == []


@pytest.mark.parametrize(
    ("nodeid", "name"),
    [
        ("tests/a/test_b.py::TestC::test_d[seed3]", "tests.a.test_b.TestC.test_d-seed3"),
        ("test_b.py::test_d", "test_b.test_d"),
    ],
)
def test_a_folder_is_named_after_its_test(nodeid, name):
    """So that people find it."""
    assert folder_name(nodeid) == name


def test_no_two_folders_are_alike():
    """What a file system does not take, or a long name, is told apart by a digest."""
    ids = [
        f"test_b.py::test[{parameter}]"
        for parameter in ("a b", "a/b", "a-b", "a:b", "a" * 300, "a" * 301)
    ]
    names = {folder_name(test_id) for test_id in ids}
    assert len(names) == len(ids)
    assert all(len(name) < 130 and "/" not in name and " " not in name for name in names)


WRONG = '''
import pytest

MISSION = """
mission: m
inputs: {room: 3}
tree: {sequence: [{check: room > 1}, {check: room > 3, name: high}]}
"""

def test_claim(stage):
    run = stage.run(MISSION)
    run.until_done()
    assert run.succeeded

def test_variable(stage):
    run = stage.run(MISSION)
    run.until_done()
    assert run.now.variables["rom"] == 3

def test_condition(stage):
    run = stage.run(MISSION)
    run.until(lambda moment: moment.leaf("hihg").failed)

def test_never(stage):
    stage.run(MISSION).until(lambda moment: False)
'''


def test_a_run_in_a_failed_assertion_tells_what_became_of_it(pytester):
    """The mission, how it ended, which nodes failed, and what to type to see it again."""
    pytester.makepyfile(test_b=WRONG)
    result = pytester.runpytest("-k", "claim")
    result.stdout.fnmatch_lines(
        [
            (
                "*where False = <run of m: failure at 0.05 s; m > high: *; if the test fails: "
                "bt-mission replay scenario_results/test_b.test_claim/recording.mcap>.succeeded"
            )
        ]
    )
    assert (pytester.path / "scenario_results/test_b.test_claim/recording.mcap").is_file()


@pytest.mark.thorough
def test_a_mistake_of_a_test_is_shown_in_the_test(pytester):
    """With the name that was meant, and without the frames of the library."""
    pytester.makepyfile(test_b=WRONG)
    result = pytester.runpytest()
    result.assert_outcomes(failed=4)
    result.stdout.fnmatch_lines(
        [
            "*unknown variable 'rom' (known: room); did you mean 'room'?",
            "*unknown node 'hihg' (known: *); did you mean 'high'?",
            "*NeverHeldError: the mission ended before the condition held*",
        ]
    )
    result.stdout.no_fnmatch_line("*bt_mission/testing/*.py:*")
    full = pytester.runpytest("--full-trace", "-k", "never")
    full.stdout.fnmatch_lines(["*bt_mission/testing/run.py:*: NeverHeldError"])


def test_an_editable_install_brings_no_warning(pytester):
    """It is given before plugins are loaded; another of its kind stays."""
    pytester.makepyfile(
        early="""
        import pytest

        def pytest_load_initial_conftests(early_config):
            for name in ("_editable_skbc_bt_mission", "another"):
                text = f"Module already imported so cannot be rewritten; {name}"
                warning = pytest.PytestAssertRewriteWarning(text)
                early_config.issue_config_time_warning(warning, stacklevel=2)
        """,
        test_c="def test_passes(): pass",
    )
    pytester.syspathinsert()
    result = pytester.runpytest("-p", "early", "-W", "default")
    result.assert_outcomes(passed=1, warnings=1)
    result.stdout.fnmatch_lines(["*cannot be rewritten; another"])
