"""`check` names `prove` to a person, once, where it applies."""

from __future__ import annotations

import sys

import pytest

from bt_mission.cli.main import main

HINT = "  'bt-mission prove square' explores every answer of its servers\n"


@pytest.mark.parametrize(
    ("files", "is_terminal", "is_shown"),
    [
        (["square"], True, True),
        (["square"], False, False),
        (["square", "patrol"], True, False),
        (["square", "--json"], True, False),
    ],
)
def test_one_mission_on_a_terminal_is_followed_by_the_hint(
    files: list[str],
    *,
    is_terminal: bool,
    is_shown: bool,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Pipes, several files and programs get what they had."""
    monkeypatch.setattr(sys.stdout, "isatty", lambda: is_terminal)
    assert main(["check", *files]) == 0
    assert capsys.readouterr().out.endswith(HINT) is is_shown
