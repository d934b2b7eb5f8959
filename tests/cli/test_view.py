"""A simulation in a window, from the command line."""

from pathlib import Path
from typing import Any

import pytest

from bt_mission.cli import main
from sim.views import window
from sim.views.window import DISPLAYS


@pytest.fixture
def mission(tmp_path: Path) -> str:
    """A mission file."""
    path = tmp_path / "mission.yaml"
    path.write_text("mission: short\ntree: {wait: 0.5}\n", encoding="utf-8")
    return str(path)


@pytest.fixture
def no_display(monkeypatch: pytest.MonkeyPatch) -> None:
    """A machine without a desktop."""
    for name in DISPLAYS:
        monkeypatch.delenv(name, raising=False)


@pytest.mark.usefixtures("no_display")
@pytest.mark.parametrize("command", ["run", "sim"])
def test_without_a_display_nothing_begins(
    command: str, mission: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """One line says why, and what to do instead."""
    assert main(["run", mission, "--view"] if command == "run" else ["sim", "--view"]) == 2
    shown = capsys.readouterr()
    assert shown.err.startswith("--view: there is no display here")
    assert (shown.err.count("\n"), shown.out) == (1, "")


def test_an_attached_run_has_nothing_to_show(
    mission: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """The simulation is in another process."""
    assert main(["run", mission, "--attach", "--view"]) == 2
    assert "add it to `bt-mission sim`" in capsys.readouterr().err


def test_a_run_is_shown_in_real_time(
    mission: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """After each tick, until it is over."""
    seen: list[str] = []

    class Shown:
        def __init__(self, physics: Any) -> None:
            seen.append("opened")

        def look(self) -> None:
            seen.append("look")

        def close(self) -> None:
            seen.append("closed")

    monkeypatch.setattr(window, "check_display", lambda: None)
    monkeypatch.setattr(window, "Window", Shown)
    assert main(["run", mission, "--view", "--json"]) == 0
    assert (seen[0], seen[-1], seen.count("look")) == ("opened", "closed", 11)
    assert float(capsys.readouterr().out.split('"real_time_factor": ')[1].split(",")[0]) <= 1.1
