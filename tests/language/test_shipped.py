"""The missions that come with the project."""

import random
from typing import Any

import pytest

from bt_mission.language.nodes.action import GoalNode
from bt_mission.sessions.check import examine
from tests.support.project import ROOT

MISSIONS = ROOT / "missions"
NAMES = sorted(path.stem for path in MISSIONS.glob("*.yaml"))


def mission_of(name, **options):
    """Return a shipped mission, which must be sound and free of warnings."""
    mission, faults = examine(MISSIONS / f"{name}.yaml", **options)
    assert faults == ()
    assert mission is not None
    return mission


@pytest.mark.parametrize("name", NAMES)
def test_a_shipped_mission_is_sound(name):
    """No error, no warning, a world, and the name of its file."""
    mission = mission_of(name)
    assert mission.name == name
    assert mission.world
    assert mission.description


@pytest.mark.parametrize(
    ("name", "given"),
    [
        ("explore", {"legs": "10", "speed": "0.15"}),
        ("patrol", {"further_rounds": "2"}),
        ("sweep", {"images": "12"}),
        ("square", {"side": "1.5"}),
    ],
)
def test_inputs_can_be_set(name, given):
    """As the first lines of the file say."""
    assert mission_of(name, set=given).inputs.keys() >= given.keys()


def test_explore_bounds_every_leg_and_turns_away():
    """Images, distance, and the sign of the turn are in the mission, not in code."""
    sweep, drive, turn = (
        step for step in mission_of("explore").tree.walk() if isinstance(step, GoalNode)
    )
    assert sweep.cancel_when is not None
    assert sweep.cancel_when.text == "current_image >= 5"
    assert drive.cancel_when is not None
    assert drive.cancel_when.text == "current_distance_travelled > 2.0"
    assert (sweep.on_cancel, drive.on_cancel) == ("success", "success")
    angle: Any = turn.sent["angle"]
    for seed in range(20):
        away = angle.expression.evaluate({"obstacle": 5.0}, random.Random(seed))
        assert -120 <= away <= -60
        assert 60 <= angle.expression.evaluate({"obstacle": -5.0}, random.Random(seed)) <= 120
        assert abs(angle.expression.evaluate({"obstacle": 0.0}, random.Random(seed))) >= 60
