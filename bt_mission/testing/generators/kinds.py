"""Kinds of faults that are drawn, in groups by what breaks."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from bt_mission.core.diagnostics import did_you_mean, quoted
from bt_mission.testing.generators.faults import DRAWN, IN_LEAVES, OF_A_BOX

GROUPS: Mapping[str, tuple[str, ...]] = {
    "network": (
        "drop",
        "delay",
        "duplicate",
        "delay_answers",
        "delay_results",
        "delay_feedback",
        "slow_server",
        "silence_feedback",
    ),
    "hardware": (
        "lidar_noise",
        "lidar_bias",
        "lidar_blind",
        "lidar_frozen",
        "lidar_dead",
        "odometry_error",
        "odometry_drift",
        "odometry_dead",
        "imu_dead",
        "joints_dead",
        "slip_wheel",
        "block_wheel",
        "motors_off",
        "push",
        "shove",
    ),
    "camera": ("camera_noise", "camera_black", "camera_frozen", "camera_dead"),
    "messages": (
        "freeze",
        "corrupt",
        "corrupt_feedback",
        "freeze_feedback",
        "forge_feedback",
        "set_fields",
        "set_feedback",
        "set_result",
    ),
    "servers": (
        "reject_goals",
        "ignore_goals",
        "drop_answers",
        "drop_results",
        "answer_after_halt",
        "repeat_answers",
        "refuse_cancels",
        "ignore_cancels",
        "abort_goal",
        "kill_server",
        "delay_service",
        "ignore_service",
        "fail_service",
    ),
    "code": ("raise_in_leaf", "raise_in_maneuver", "raise_in_callback"),
    "battery": ("battery_charge",),
    "clock": ("jump_clock", "stop_clock"),
}
"""The first is the simplest of each."""

DEFAULT_KINDS = ("network", "hardware", "servers", "messages")
"""Groups that faults are drawn from where the ranges name none; those of the camera and the battery
besides, where the mission uses them."""

_DRAWABLE = (*(set(DRAWN) - set(OF_A_BOX) - {"spawn_box", "spawn_cylinder"}), *IN_LEAVES)


def unknown_kind(name: str) -> tuple[str, str | None] | None:
    """Tell what is wrong with the name of a kind or group, and a hint; None if it is one."""
    if name in GROUPS or name in _DRAWABLE:
        return None
    if name in ("spawn_box", "spawn_cylinder", *OF_A_BOX):
        return f"{quoted(name)}: obstacles have ranges of their own, 'obstacles:'", None
    near = did_you_mean(name, (*GROUPS, *_DRAWABLE))
    known = None if near else f"groups: {', '.join(GROUPS)}; or the name of a fault"
    return f"there is no fault {quoted(name)} that can be drawn", near or known


def faults_of(kinds: Iterable[str]) -> tuple[str, ...]:
    """Return the faults of kinds and groups, each once."""
    return tuple(dict.fromkeys(one for kind in kinds for one in GROUPS.get(kind, (kind,))))
