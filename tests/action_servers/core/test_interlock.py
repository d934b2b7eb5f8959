"""Facts about what keeps goals away for a while."""

from __future__ import annotations

import pytest

from action_servers.core.error_codes import ErrorCode
from action_servers.core.governor import Governor
from action_servers.core.maneuver import ZERO
from action_servers.core.pilot import (
    REFUSED_WHILE_DRIVING,
    Interlock,
    ManeuverOutcome,
    ManeuverRun,
    Pilot,
)
from bt_mission.core.geometry import Twist2D
from bt_mission.core.robot.model import load_robot
from tests.support.fake_robot import in_the_open


class Idle:
    """A maneuver that goes on."""

    def __init__(self, *, needs_base):
        self.needs_base = needs_base

    def step(self, now):
        return ZERO

    def feedback(self):
        return None

    def result(self):
        return {}


def make(**options):
    """An interlock, its pilot, and what was commanded."""
    commands: list[Twist2D] = []
    governor = Governor(load_robot("waffle"))
    pilot = Pilot(lambda: in_the_open(1.0), commands.append, governor, **options)
    return Interlock(pilot), pilot, commands


def run(pilot, *, needs_base):
    """A running maneuver's list of ends."""
    ends: list[ManeuverOutcome] = []
    pilot.start(ManeuverRun(Idle(needs_base=needs_base), lambda _: None, ends.append))
    return ends


def test_a_stop_ends_everything_and_refuses_until_release():
    """Zero velocity first."""
    interlock, pilot, commands = make()
    ends = [run(pilot, needs_base=True), run(pilot, needs_base=False)]
    interlock.stop()
    assert [end[0].reason for end in ends] == ["stopped", "stopped"]
    assert commands[-1] == ZERO
    for needs_base in (True, False):
        assert interlock.refusal(needs_base=needs_base) == (
            "stopped; call the service release to continue"
        )
    interlock.release()
    assert interlock.refusal(needs_base=True) is None


def test_motors_that_are_off_end_and_refuse_only_what_drives():
    """Until they are on."""
    interlock, pilot, _ = make()
    drive, beside = run(pilot, needs_base=True), run(pilot, needs_base=False)
    interlock.set_motors(on=False)
    assert (drive[0].error_code, drive[0].reason) == (ErrorCode.MOTORS_OFF, "motors off")
    assert beside == []
    refusal = interlock.refusal(needs_base=True)
    assert refusal is not None
    assert refusal.startswith("motors off")
    assert interlock.refusal(needs_base=False) is None
    interlock.set_motors(on=True)
    assert interlock.refusal(needs_base=True) is None


def test_a_release_does_not_switch_the_motors_on():
    """Two causes, each with its own end."""
    interlock, _, _ = make()
    interlock.set_motors(on=False)
    interlock.stop()
    interlock.release()
    assert interlock.refusal(needs_base=True) is not None


@pytest.mark.parametrize(("replaces", "refusal"), [(True, None), (False, REFUSED_WHILE_DRIVING)])
def test_the_pilots_own_rule_comes_last(replaces, refusal):
    """A goal that would replace another, where it must not."""
    interlock, pilot, _ = make(replaces=replaces)
    assert interlock.refusal(needs_base=True) is None
    run(pilot, needs_base=True)
    assert interlock.refusal(needs_base=True) == refusal
