"""Callables that are called when something happens."""

from __future__ import annotations

from bt_mission.executive.listeners import Listeners


def test_one_that_raises_is_called_no_more_and_keeps_nobody_from_being_called():
    """What it has raised is given; to remove it again changes nothing."""
    called: list[int] = []
    broken = ValueError("broken")

    def fail(_: int) -> None:
        raise broken

    listeners: Listeners[[int]] = Listeners([fail, called.append])
    assert listeners.notify(1) == [broken]
    assert listeners.notify(2) == []
    assert called == [1, 2]
    listeners.remove(fail)
    assert listeners == [called.append]


def test_one_may_leave_while_it_is_called():
    """The others are called all the same."""
    called: list[str] = []
    listeners: Listeners[[]] = Listeners()

    def leave() -> None:
        listeners.remove(leave)
        called.append("leaver")

    listeners += [leave, lambda: called.append("other")]
    assert [*listeners.notify(), *listeners.notify()] == []
    assert called == ["leaver", "other", "other"]
