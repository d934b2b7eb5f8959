"""What comes between the pilot and a maneuver can have it fail, and otherwise changes nothing."""

from __future__ import annotations

from typing import Any

import pytest

from action_servers.core.maneuver import Finished, Observation
from action_servers.robot_io.adapter import Before, HookedManeuver
from bt_mission.core.geometry import Twist2D


class Drive:
    """Drives, and counts its steps."""

    needs_base = True

    def __init__(self) -> None:
        self.steps = 0

    def step(self, now: Observation) -> Twist2D:
        self.steps += 1
        return Twist2D(0.1)

    def feedback(self) -> Any:
        return {"steps": self.steps} if self.steps != 2 else None

    def result(self) -> Any:
        return {"steps": self.steps}


def test_by_itself_it_changes_nothing() -> None:
    """Velocity, feedback and result are the maneuver's."""
    maneuver = HookedManeuver(Drive(), [])
    assert maneuver.needs_base
    assert maneuver.step(Observation(0.0)) == Twist2D(0.1)
    assert (maneuver.feedback(), maneuver.result()) == ({"steps": 1}, {"steps": 1})


def test_it_is_asked_before_each_method_with_the_newest_feedback() -> None:
    """It may join and leave while the maneuver runs; what it gives before a step ends the goal."""
    asked: list[Any] = []

    def note(method: str, feedback: Any) -> None:
        asked.append((method, dict(feedback)))

    before: list[Before] = []
    maneuver = HookedManeuver(Drive(), before)
    maneuver.step(Observation(0.0))
    before.append(note)
    maneuver.feedback()
    maneuver.step(Observation(0.1))
    maneuver.feedback()
    maneuver.result()
    assert asked == [
        ("feedback", {}),
        ("step", {"steps": 1}),
        ("feedback", {"steps": 1}),
        ("result", {"steps": 1}),
    ]
    before[:] = [lambda method, _: (906, "stuck") if method == "step" else None]
    assert maneuver.step(Observation(0.2)) == Finished("aborted", 906, "stuck")
    before.clear()
    assert maneuver.step(Observation(0.3)) == Twist2D(0.1)


def test_what_it_raises_the_maneuver_raises() -> None:
    """As a fault in the maneuver's own code."""

    def fail(_method: str, _feedback: Any) -> None:
        raise KeyError("no such sensor")

    maneuver = HookedManeuver(Drive(), [fail])
    with pytest.raises(KeyError):
        maneuver.step(Observation(0.0))
