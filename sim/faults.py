"""What can break on a robot while the simulation runs: one record for each part, set at any time.

    robot.faults.set("lidar", noise=0.1, sectors=((-20, 20),))
    robot.faults.set("lidar", dead=True)         # the noise stays set, for when it lives again
    robot.faults.set("wheels", left_blocked=True)
    robot.faults.clear("lidar")
    robot.faults.clear()

A sensor's fault shows from its next measurement on, a wheel's from the next step of the physics.
Its random values depend only on the robot's seed and the number of the measurement.
"""

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from bt_mission.base.diagnostics import did_you_mean, listed
from bt_mission.base.errors import BtMissionError


class FaultError(BtMissionError):
    """A fault that a robot cannot have."""

    code = "BT-703"


def expected(text: str, **limits: Any) -> Any:
    """Return the expected values of a figure, with its limits as pydantic has them."""
    return Field(description=text, **limits)


def within(least: float, most: float, unit: str) -> Any:
    """Return the limits of a number, both included."""
    return expected(f"{least:g} to {most:g} {unit}", ge=least, le=most, allow_inf_nan=False)


class PartFaults(BaseModel):
    """The faults of one part. Raises FaultError for an invalid value."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    def __init__(self, **values: Any) -> None:
        try:
            super().__init__(**values)
        except ValidationError as error:
            name = str(error.errors()[0]["loc"][0])
            wanted = type(self).model_fields[name].description or "True or False"
            raise FaultError(f"{name}: expected {wanted}, got {values[name]!r}") from None


class SensorFaults(PartFaults):
    """A sensor that is silent."""

    dead: bool = False
    """It publishes nothing."""


Grip = Annotated[float, within(0, 1, "(1: as it is)")]


class WheelFaults(PartFaults):
    """Wheels that slip, or do not turn."""

    left_grip: Grip = 1.0
    """Its coefficient of friction on any surface; on a slippery place the lower one counts."""
    right_grip: Grip = 1.0
    left_blocked: bool = False
    right_blocked: bool = False


class RobotFaultState:
    """The present faults of one robot, part by part: `state["lidar"].noise`.

    Initially there are only those of :meth:`set_usual`.

    Args:
        parts: The parts that can have faults, each without one.
        on_wheels: Called with every change of the wheels' faults.
        lacks: Why parts of other robots cannot have faults here.
    """

    def __init__(
        self,
        parts: Mapping[str, PartFaults],
        on_wheels: Callable[[WheelFaults], None],
        lacks: Mapping[str, str] = MappingProxyType({}),
    ) -> None:
        self._on_wheels = on_wheels
        self.lacks = lacks
        self._none = dict(parts)
        self._usual = dict(parts)
        self.now: dict[str, Any] = dict(parts)
        """The faults of each part, by its name; read only."""

    def __getitem__(self, part: str) -> Any:
        """Return the faults of a part; the same object as long as it has none."""
        return self.now[part]

    def set(self, part: str, **changes: Any) -> None:
        """Change faults of a part; the others stay.

        Raises FaultError for an unknown part or fault, or an invalid value.
        """
        if part in self.lacks:
            raise FaultError(self.lacks[part])
        known = list(type(self._of(part)).model_fields)
        for name in changes:
            if name not in known:
                raise FaultError(_unknown(f"fault '{name}' of the part '{part}'", name, known))
        try:
            self._put(part, _changed(self._of(part), changes))
        except FaultError as error:
            raise FaultError(f"{part}: {error}") from None

    def set_usual(self, part: str, **usual: Any) -> None:
        """Make figures of a part usual: it has them now, and again whenever it is cleared."""
        self._usual[part] = _changed(self._none[part], usual)
        self._put(part, self._usual[part])

    def clear(self, part: str | None = None) -> None:
        """Make a part as usual, or all. Raises FaultError for an unknown part."""
        for each in self._none if part is None else (part,):
            self._of(each)
            self._put(each, self._usual[each])

    @property
    def present(self) -> dict[str, PartFaults]:
        """The parts with which something is wrong."""
        return {
            part: self.now[part] for part, usual in self._usual.items() if self.now[part] != usual
        }

    def _of(self, part: str) -> PartFaults:
        if part not in self._none:
            raise FaultError(_unknown(f"part '{part}' that can break", part, list(self._none)))
        faults: PartFaults = self.now[part]
        return faults

    def _put(self, part: str, faults: PartFaults) -> None:
        # Readers recognize a part without faults by identity.
        none = self._none[part]
        self.now[part] = none if faults == none else faults
        if isinstance(faults, WheelFaults):
            self._on_wheels(faults)


def _changed(faults: PartFaults, changes: Mapping[str, Any]) -> PartFaults:
    return type(faults)(**{**dict(faults), **changes})


def _unknown(what: str, name: str, known: list[str]) -> str:
    near = did_you_mean(name, known)
    return f"there is no {what} (known: {listed(known)})" + (f"; {near}" if near else "")
