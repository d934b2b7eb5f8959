"""A simulation in a window, from the command line."""

from typing import Any

import pytest

from sim.views import window
from sim.views.window import DISPLAYS
from tests.support.command_line import CommandLine

MISSION = "mission: short\ntree: {wait: 0.5}\n"


@pytest.mark.parametrize("command", ["run m.yaml", "sim"])
def test_without_a_display_nothing_begins(
    command: str, cli: CommandLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One line says why, and what to do instead."""
    for name in DISPLAYS:
        monkeypatch.delenv(name, raising=False)
    cli.write("m.yaml", MISSION)
    error = cli.refused(f"{command} --view")
    assert error.startswith("--view: there is no display here")
    assert error.count("\n") == 1


def test_a_run_is_shown_in_real_time(cli: CommandLine, monkeypatch: pytest.MonkeyPatch) -> None:
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
    report = cli.json(f"run {cli.write('m.yaml', MISSION)} --view")
    assert (seen[0], seen[-1], seen.count("look")) == ("opened", "closed", 11)
    assert report["real_time_factor"] <= 1.1
