"""The nodes of Nav2 that mean something here: each as the data of a node of a mission."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from bt_mission.btcpp.attributes import LocatedValue, located
from bt_mission.btcpp.node_parts import NodeElement
from bt_mission.core.diagnostics import quoted
from bt_mission.language.action_names import ACTION_NAMES, ActionName

Read = Callable[[NodeElement], dict[str, Any]]
Goal = Callable[[NodeElement], dict[str, Any]]

_OUTPUTS = {"error_code_id": "error_code", "error_msg": "error_msg"}
_EVERY_ACTION = ("server_name", "server_timeout", *_OUTPUTS)
_WAIT = ActionName("wait", "nav2_msgs/action/Wait")


def _action(kind: str, goal: Goal) -> Read:
    """Return what reads an action: the kind with its short name, where its server has that name."""

    def read(node: NodeElement) -> dict[str, Any]:
        fields = goal(node)
        short, server = ACTION_NAMES.get(kind, _WAIT), node.take("server_name", needed=False)
        named: dict[str, Any] = {kind: fields}
        if kind not in ACTION_NAMES or (server is not None and server.value != short.action):
            name = short.action if server is None else located(server.value, server.value_at)
            named = {"action": {"name": name, "type": short.type, "goal": fields}}
        if node.has("server_timeout"):
            named["acceptance_timeout"] = node.seconds("server_timeout")
        outputs = {field: node.variable(name) for name, field in _OUTPUTS.items() if node.has(name)}
        return {**named, **({"outputs": outputs} if outputs else {})}

    return read


def _allowed(node: NodeElement) -> dict[str, Any]:
    """Return the time limit of a maneuver; its collision checks cannot be turned off."""
    unchecked = node.take("disable_collision_checks", needed=False)
    if unchecked is not None and unchecked.value != "false":
        message = f"expected false, got {quoted(unchecked.value)}: obstacles are always looked at"
        node.report(unchecked.value_at, message)
    return {"time_allowance": node.value("time_allowance", 10.0)}


def _spin(node: NodeElement) -> dict[str, Any]:
    node.take("is_recovery", needed=False)  # counts for the feedback of Nav2's navigator only
    return {"target_yaw": node.value("spin_dist", 1.57), **_allowed(node)}


def _straight(distance: str, speed: str) -> Goal:
    def goal(node: NodeElement) -> dict[str, Any]:
        target = {"x": node.value(distance, 0.15)}
        return {"target": target, "speed": node.value(speed, 0.025), **_allowed(node)}

    return goal


def _wait(node: NodeElement) -> dict[str, Any]:
    seconds = node.value("wait_duration", 1.0)
    if isinstance(seconds.data, int | float):
        return {"time": LocatedValue(abs(seconds.data), seconds.place)}
    return {"time": seconds}


def _navigate(node: NodeElement) -> dict[str, Any]:
    goal: dict[str, Any] = {"pose": node.reference("goal", "a list [x m, y m, yaw deg]")}
    if node.has("behavior_tree"):
        goal["behavior_tree"] = node.value("behavior_tree", "")
    return goal


def _clear(node: NodeElement) -> dict[str, Any]:
    service: dict[str, Any] = {
        "name": node.value("service_name", ""),
        "type": "nav2_msgs/srv/ClearEntireCostmap",
    }
    found: dict[str, Any] = {"service": service}
    if node.has("server_timeout"):
        found["timeout"] = node.seconds("server_timeout")
    return found


def _recovery(node: NodeElement) -> dict[str, Any]:
    """Return a RecoveryNode: after each failure of the one the other, up to a number of times.

    It fails with the other one, and with the one after the last recovery.
    """
    most = node.times("number_of_retries", 0) if node.has("number_of_retries") else 1
    tried, recovered = node.exactly(2)
    most = most.data if isinstance(most, LocatedValue) else most
    place = "_".join(str(part) for part in node.at)
    count, done = f"recoveries_{place}", f"done_{place}"
    attempts = f"{most} + 1" if isinstance(most, str) else most + 1
    recovery = [
        {"set": {done: False}},
        {"check": f"{count} < {most}"},
        {"set": {count: f"{count} + 1"}},
        {"invert": node.read(recovered)},
    ]
    body = [{"sequence": [node.read(tried), {"set": {done: True}}]}, {"sequence": recovery}]
    steps = [
        {"set": {count: 0, done: False}},
        {"retry": {"attempts": attempts}, "do": {"fallback": body}},
        {"check": done},
    ]
    return {"sequence": steps}


NAV2: Mapping[str, tuple[tuple[str, ...], Read]] = {
    tag: ((*names, *(() if tag in ("ClearEntireCostmap", "RecoveryNode") else _EVERY_ACTION)), read)
    for tag, names, read in (
        (
            "Spin",
            ("spin_dist", "time_allowance", "is_recovery", "disable_collision_checks"),
            _action("spin", _spin),
        ),
        (
            "BackUp",
            ("backup_dist", "backup_speed", "time_allowance", "disable_collision_checks"),
            _action("back_up", _straight("backup_dist", "backup_speed")),
        ),
        (
            "DriveOnHeading",
            ("dist_to_travel", "speed", "time_allowance", "disable_collision_checks"),
            _action("drive_on_heading", _straight("dist_to_travel", "speed")),
        ),
        ("Wait", ("wait_duration",), _action("wait", _wait)),
        ("NavigateToPose", ("goal", "behavior_tree"), _action("navigate_to_pose", _navigate)),
        ("ClearEntireCostmap", ("service_name", "server_timeout"), _clear),
        ("RecoveryNode", ("number_of_retries",), _recovery),
    )
}
"""The nodes that are read: their attributes, and what reads them."""

_AGAIN = "it ticks children again that have ended; write a 'Sequence', or a 'Parallel' of loops"
_PATHS = "variables hold no paths; 'NavigateToPose' has its server plan and follow one"
HINTS = {
    "PipelineSequence": _AGAIN,
    "RoundRobin": "it goes on where it ended the last time; write a 'Fallback'",
    **dict.fromkeys(
        ("RateController", "DistanceController", "SpeedController", "GoalUpdatedController"),
        "it starts a child that has ended again; write a 'Repeat' with a 'Sleep' in it",
    ),
    **dict.fromkeys(("ComputePathToPose", "ComputePathThroughPoses", "FollowPath"), _PATHS),
    **dict.fromkeys(
        ("ControllerSelector", "PlannerSelector", "GoalCheckerSelector", "SmootherSelector"),
        "it chooses a plug-in for the nodes that plan and follow paths; leave it out with them",
    ),
}
"""Why others are not, and what to write instead."""
