"""What a mission gives to draw from."""

from __future__ import annotations

import asyncio
from pathlib import Path

import pytest

from bt_mission.commands.falsify.material import Material, branch_formulas, material_of, present_in
from bt_mission.scenarios.concrete.base_scenario import BaseChanges, BaseScenario, load_base
from bt_mission.scenarios.concrete.worker import ScenarioWorker
from bt_mission.scenarios.faults.drawable import FieldValues

MISSION = """\
mission: rich
world: empty_arena
inputs: {far: 0.8, low: 20}
follow:
  - {topic: /battery_state, type: sensor_msgs/msg/BatteryState, field: percentage, as: charge}
requirements:
  turns enough: never feedback("round", "remaining_angle") < -5
tree:
  sequence:
    - explore_forward: {fwd_velocity: 0.2, stopping_distance: 0.4}
      name: drive
      cancel_when: current_distance_travelled > $far
      on_cancel: success
      timeout: 12
      feedback_timeout: 1.5
      acceptance_timeout: 0.7
      outputs: {closest_obstacle_angle: bearing}
    - when: $bearing > 10 and $charge > low
      do: {turn: {angle: 30}, name: round, timeout: 9}
    - service: {name: motor_power, type: std_srvs/srv/SetBool, request: {data: true}}
"""


def loaded(folder: Path, text: str) -> BaseScenario:
    """Load a mission from a file."""
    path = folder / "mission.yaml"
    path.write_text(text)
    return load_base(path, BaseChanges())


@pytest.fixture
def given(tmp_path: Path) -> Material:
    """What a mission that reads much gives."""
    return material_of(loaded(tmp_path, MISSION).mission)


def test_names(given: Material) -> None:
    """Its actions, its services, and the topics that it follows beside those of every mission."""
    assert given.actions == ("explore_forward", "turn")
    assert given.services == ("motor_power",)
    assert set(given.topics) == {"scan", "odom", "cmd_vel", "tf", "battery_state"}
    assert given.topics["battery_state"] == "sensor_msgs/msg/BatteryState"
    assert (given.uses_battery, given.uses_camera) == (True, False)


def test_limits(given: Material) -> None:
    """Each a little less and a little more."""
    limits = set(given.limits)
    assert {11.9, 12.1, 1.4, 1.6, 0.6, 0.8} <= limits
    assert {4.9, 5.1, 0.5, 0.7} <= limits  # of the default, and of our servers


def test_topics_that_it_trusts(given: Material, tmp_path: Path) -> None:
    """Each with periods beside and well beyond its own limits."""
    assert given.trusted == {"battery_state": ()}
    text = (
        "mission: m\nrequirements: {sees: always age('scan') < 0.5}\n"
        "follow:\n  - {topic: odom, type: nav_msgs/msg/Odometry, as: x, timeout: 2,"
        " field: pose.pose.position.x}\n"
        "tree:\n  wait_for: {topic: motors_on, type: std_msgs/msg/Bool, until: data}\n"
        "  timeout: 10\n"
    )
    assert material_of(loaded(tmp_path, text).mission).trusted == {
        "odom": (2.1, 2.8, 1.9),
        "motors_on": (10.1, 14.0, 9.9),
        "scan": (0.6, 0.7, 0.4),
    }


def test_values_beside_comparisons(given: Material) -> None:
    """Of feedback, results that variables come from, followed topics, and requirements."""
    result = {(field.fault, field.field): field.values for field in given.fields}
    assert {0.79, 0.8, 0.81} <= set(result["set_feedback", "current_distance_travelled"])
    assert {9.9, 10.0, 10.1} <= set(result["set_result", "closest_obstacle_angle"])
    assert {19.8, 20.0, 20.2} <= set(result["set_fields", "percentage"])
    assert {-5.05, -5.0, -4.95} <= set(result["set_feedback", "remaining_angle"])


def test_values_fit_their_fields(tmp_path: Path) -> None:
    """A code is no fraction and not below 0, and a field that is not there has none."""
    text = (
        "mission: codes\ntree:\n  sequence:\n"
        "    - {turn: {angle: 30}, timeout: 9, outputs: {error_code: code}}\n"
        "    - check: $code == 0\n"
    )
    (field,) = material_of(loaded(tmp_path, text).mission).fields
    assert field == FieldValues("set_result", "turn", "error_code", (0, 1))


def test_events(given: Material) -> None:
    """Nodes that begin and end, and feedback on its way to a limit."""
    assert {'running("drive")', 'succeeded("drive")', 'failed("round")'} <= set(given.events)


def test_branches_are_requirements(given: Material) -> None:
    """A cancel condition is to become true, a condition on variables both."""
    formulas = branch_formulas(given.branches)
    assert set(formulas.values()) == {
        'never feedback("drive", "current_distance_travelled") > $far',
        "never $bearing > 10 and $charge > $low",
        "always $bearing > 10 and $charge > $low",
    }


def test_what_is_not_there_is_not_drawn(tmp_path: Path) -> None:
    """An action without a server, a service without one, and a sensor that the robot lacks."""
    base = loaded(
        tmp_path,
        "mission: lonely\nworld: empty_arena\nrobot: burger\ntree:\n  fallback:\n"
        "    - action: {name: /nowhere, type: nav2_msgs/action/Spin}\n"
        "      timeout: 3\n"
        "    - service: {name: /nobody, type: std_srvs/srv/Trigger}\n"
        "    - {turn: {angle: 5}, timeout: 9}\n",
    )
    given = material_of(base.mission)
    with ScenarioWorker(base.bundle) as worker:
        there = asyncio.run(present_in(given, base, worker))
    assert given.actions == ("/nowhere", "turn")
    assert there.actions == ("turn",)
    assert (given.services, there.services) == (("/nobody",), ())
    assert set(there.topics) == {"scan", "odom", "cmd_vel", "tf"}
    assert {"camera_dead", "camera_black"} <= there.lacking
    assert not any(fault.startswith("lidar") for fault in there.lacking)
