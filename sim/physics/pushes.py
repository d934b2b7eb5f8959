"""Pushes and shoves: external forces on a robot, for a time or at once."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import mujoco

from sim.faults import FaultError
from sim.physics.names import BASE, STEP_NS

Frame = Literal["robot", "map"]
"""Axes of a push: x ahead and y to the left, or those of the map."""

STRONGEST = 50.0
"""N: three times a Waffle's weight."""

STRONGEST_TORQUE = 5.0
"""N m."""

FASTEST = 5.0
"""m/s."""

FASTEST_TURN = 10.0
"""rad/s."""


@dataclass(frozen=True, slots=True)
class _Push:
    force: tuple[float, float]
    torque: float
    frame: Frame
    end_ns: int


class Pushes:
    """The external forces on one robot's base, at its centre of mass."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, prefix: str) -> None:
        joint = int(model.joint(prefix + BASE).dofadr[0])
        self._velocity = data.qvel[joint : joint + 6]
        self._applied = data.xfrc_applied[model.body(prefix + BASE).id]
        self.acting: list[_Push] = []
        """The present pushes; always the same list."""

    def add(
        self,
        force: tuple[float, float],
        torque: float,
        frame: Frame,
        seconds: float,
        now_ns: int,
    ) -> None:
        """Add one from now on. Raises FaultError for an invalid one."""
        _check_frame(frame)
        if not (math.hypot(*force) <= STRONGEST and abs(torque) <= STRONGEST_TORQUE):
            raise FaultError(
                f"expected a push of at most {STRONGEST:g} N and {STRONGEST_TORQUE:g} N m, got"
                f" {force} N and {torque:g} N m"
            )
        if not 0 < seconds < math.inf:
            raise FaultError(f"expected a push for a time above 0 s, got {seconds:g} s")
        steps = max(1, round(seconds * 1e9 / STEP_NS))
        self.acting.append(_Push(force, torque, frame, now_ns + steps * STEP_NS))

    def shove(self, velocity: tuple[float, float], turn: float, frame: Frame, yaw: float) -> None:
        """Give the base a velocity at once. Raises FaultError for what cannot be."""
        _check_frame(frame)
        if not (math.hypot(*velocity) <= FASTEST and abs(turn) <= FASTEST_TURN):
            raise FaultError(
                f"expected a shove of at most {FASTEST:g} m/s and {FASTEST_TURN:g} rad/s, got"
                f" {velocity} m/s and {turn:g} rad/s"
            )
        self._velocity[:2] = _on_map(*velocity, frame, yaw)
        self._velocity[5] = turn

    def apply(self, now_ns: int, yaw: float) -> None:
        """Set the sum of all for the step that begins now; remove those that have ended."""
        self.acting[:] = [push for push in self.acting if now_ns < push.end_ns]
        total_x = total_y = torque = 0.0
        for push in self.acting:
            x, y = _on_map(*push.force, push.frame, yaw)
            total_x, total_y, torque = total_x + x, total_y + y, torque + push.torque
        self._applied[:] = (total_x, total_y, 0.0, 0.0, 0.0, torque)

    def forget(self) -> None:
        """Let all end."""
        self.acting.clear()
        self._applied[:] = 0.0


def _on_map(x: float, y: float, frame: Frame, yaw: float) -> tuple[float, float]:
    """Return a vector in the axes of the map."""
    if frame == "map":
        return x, y
    cos, sin = math.cos(yaw), math.sin(yaw)
    return cos * x - sin * y, sin * x + cos * y


def _check_frame(frame: str) -> None:
    """Raise FaultError for invalid axes."""
    if frame not in {"robot", "map"}:
        raise FaultError(f"expected frame 'robot' or 'map', got '{frame}'")
