"""What the parts of a robot's file have in common: immutable figures without unknown keys."""

from typing import Annotated

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, JsonValue
from pydantic.fields import FieldInfo


def _within(unit: str, least: float, most: float) -> AfterValidator:
    """Refuse numbers that no real robot has: they are in another unit."""

    def check(value: float) -> float:
        if not least <= value <= most:
            bound = f"at most {most:g}" if value > most else f"at least {least:g}"
            raise ValueError(f"expected {bound} {unit}, got {value:g}; is it in {unit}?")
        return value

    return AfterValidator(check)


def _above_0(unit: str, most: float, least: float = 0.0) -> tuple[FieldInfo, AfterValidator]:
    """Bounds of a number above 0, in its model and in the schema."""
    shown: dict[str, JsonValue] = {"minimum": least} if least else {}
    schema = Field(gt=0, allow_inf_nan=False, json_schema_extra={**shown, "maximum": most})
    return schema, _within(unit, least, most)


def _noise(unit: str, most: float) -> tuple[FieldInfo, AfterValidator]:
    """Bounds of a standard deviation."""
    schema = Field(ge=0, allow_inf_nan=False, json_schema_extra={"maximum": most})
    return schema, _within(unit, 0.0, most)


Number = Annotated[float, Field(allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
_LONGEST_M = 10
Length = Annotated[float, *_above_0("m", _LONGEST_M)]
WheelRadius = Annotated[float, *_above_0("m", 1)]
Place = Annotated[
    float,
    Field(allow_inf_nan=False, json_schema_extra={"minimum": -_LONGEST_M, "maximum": _LONGEST_M}),
    _within("m", -_LONGEST_M, _LONGEST_M),
]
Distance = Annotated[float, *_above_0("m", 1000)]
Speed = Annotated[float, *_above_0("m/s", 50)]
Acceleration = Annotated[float, *_above_0("m/s^2", 100)]
TurnRate = Annotated[float, *_above_0("rad/s", 50)]
AngularAcceleration = Annotated[float, *_above_0("rad/s^2", 1000)]
Mass = Annotated[float, *_above_0("kg", 10_000)]
Rate = Annotated[float, *_above_0("Hz", 1000, least=0.1)]
ControlRate = Annotated[float, *_above_0("Hz", 1000, least=1)]
Timeout = Annotated[float, *_above_0("s", 10)]
RangeNoise = Annotated[float, *_noise("m", 1)]
GyroNoise = Annotated[float, *_noise("rad/s", 1)]
AccelerationNoise = Annotated[float, *_noise("m/s^2", 10)]
Point2 = tuple[Place, Place]
Point3 = tuple[Place, Place, Place]
Extent3 = tuple[Length, Length, Length]
Size3 = tuple[Positive, Positive, Positive]


class RobotPart(BaseModel):
    """Figures of a part: immutable, without unknown keys."""

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)
