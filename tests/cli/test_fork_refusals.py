"""What a fork refuses, and recordings that hold less than a fork needs."""

from __future__ import annotations

from pathlib import Path

import pytest

from bt_mission.cli import main
from tests.support.forks import forked, record_mission, refused
from tests.support.recordings import edited, with_facts


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> str:
    """A recorded run."""
    return str(record_mission(tmp_path_factory.mktemp("fork")))


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["--at", "1", "--set", "sped=1"], "no variable 'sped' (the mission's: speed, angle, way)"),
        (["--at", "1", "--set", "sped=1"], "did you mean 'speed'?"),
        (["--at", "1", "--set", "speed=fast"], "input 'speed' expects a number, got string 'fast'"),
        (["--at", "999"], "--at 999: the run ends at "),
    ],
)
def test_a_change_that_does_not_fit(
    run: str, words: list[str], expected: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Is refused before anything runs."""
    assert expected in refused(capsys, run, *words)


def test_before_the_start_there_is_nothing(run: str, capsys: pytest.CaptureFixture[str]) -> None:
    """A time below 0 is none."""
    with pytest.raises(SystemExit, match="2"):
        main(["fork", run, "--at", "-1"])
    assert "--at: expected seconds from 0, such as 12.5, got '-1'" in capsys.readouterr().err


def test_a_recording_that_was_cut_is_forked_before_its_end(
    run: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """What became of the run is not known then."""
    path = tmp_path / "cut.mcap"
    data = Path(run).read_bytes()
    path.write_bytes(data[: len(data) // 2])
    error = refused(capsys, str(path), "--at", "99")
    end_s = float(error.rpartition("the recording ends at ")[2].split()[0])
    told = forked(capsys, str(path), "--at", str(end_s), "--set", "speed=0.1")
    assert told["recorded"]["status"] == "unknown"
    assert "the file was cut" in told["recorded"]["reason"]
    assert told["forked"]["status"] == "success"
    assert main(["fork", str(path), "--at", "1"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[3].endswith("(recorded: not known)")
    assert lines[4].endswith(" events of the trace that were recorded, byte by byte")


def test_files_that_hold_no_run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Empty, of another kind, of another recorder, and none at all."""
    empty, text, foreign = (tmp_path / name for name in ("empty.mcap", "text", "foreign.mcap"))
    empty.write_bytes(b"")
    text.write_text("no recording", encoding="utf-8")
    edited(foreign, lambda *_: True)
    for path, expected in (
        (empty, "the file is empty"),
        (text, "not an MCAP file"),
        (foreign, "no run of bt-mission is in it"),
        (tmp_path / "none.mcap", "cannot read it: No such file"),
    ):
        assert expected in refused(capsys, str(path), "--at", "1")


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"world": None, "stage": None}, "it has no seed: it was recorded against the servers"),
        ({"stage": None}, "it lacks the files of world and robot"),
        ({"stage": "{}"}, "it lacks the files of world and robot"),
        ({"file": "gone.yaml"}, "it lacks the mission's file 'gone.yaml'"),
        ({"seed": "-"}, "it has no seed"),
        (
            {"requirements": '[{"name": "a", "formula": "always"}]'},
            "its requirement 'a' cannot be read here",
        ),
    ],
)
def test_a_recording_that_lacks_something(
    changes: dict[str, str | None],
    expected: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Is named with what it lacks."""
    path = with_facts(tmp_path / "lacking.mcap", changes)
    assert expected in refused(capsys, str(path), "--at", "1")


def test_another_run_is_told_apart(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """By the first event that is another one, with what is of another version."""
    changes = {"inputs": '{"reach": 0.3}', "versions": '{"mujoco": "1.0"}'}
    path = with_facts(tmp_path / "other.mcap", changes)
    error = refused(capsys, str(path), "--at", "99999")
    assert "recorded with mujoco 1.0, here it is " in error
    error = refused(capsys, str(path), "--at", "7")
    assert "run again, it is not the same up to 7.00 s, so it cannot be forked there" in error
    assert "they part at " in error
    assert error.count("recorded with mujoco 1.0, here it is ") == 2


def test_the_code_of_python_leaves_is_not_run_unasked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A recording may be anybody's."""
    monkeypatch.chdir(tmp_path)
    Path("leaf.py").write_text(
        "import py_trees\n\n\nclass Leaf(py_trees.behaviours.Success):\n    pass\n"
    )
    Path("m.yaml").write_text("mission: m\ntree: {python: 'leaf.py:Leaf'}\n")
    assert main(["run", "m.yaml", "--json", "--record", "run.mcap"]) == 0
    error = refused(capsys, "run.mcap", "--at", "0")
    assert "the Python leaf 'leaf.py:Leaf' is refused" in error
    assert "--import-python" in error
    assert forked(capsys, "run.mcap", "--at", "0", "--import-python")["is_identical"]


def test_recordings_of_before(capsys: pytest.CaptureFixture[str]) -> None:
    """Hold less than a fork needs."""
    old = Path(__file__).parents[1] / "data" / "recordings"
    for path in sorted(old.glob("*.mcap")):
        assert "record the run again" in refused(capsys, str(path), "--at", "0")


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ([], "say where to fork with --at S"),
        (["--sweep-at", "--set", "speed=0.1"], "there is nothing to save"),
    ],
)
def test_options_that_contradict_each_other(
    run: str, words: list[str], expected: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Are refused, with what to do; so is a sweep over a run that needs no saving."""
    assert expected in refused(capsys, run, *words)
