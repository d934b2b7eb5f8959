"""What the parts of a robot's file have in common: immutable figures without unknown keys."""

from __future__ import annotations

from typing import Annotated

from pydantic import AfterValidator, BaseModel, ConfigDict, Field


def _up_to(most: float, unit: str) -> AfterValidator:
    """Refuse numbers so large that they are in another unit."""

    def check(value: float) -> float:
        if abs(value) > most:
            bound = f"at most {most:g}" if value > 0 else f"at least {-most:g}"
            raise ValueError(f"expected {bound} {unit}, got {value:g}; is it in {unit}?")
        return value

    return AfterValidator(check)


Number = Annotated[float, Field(allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
_LONGEST_M, _FARTHEST_M, _FASTEST_M_S, _HEAVIEST_KG = 10, 1000, 50, 10_000
Length = Annotated[
    float,
    Field(gt=0, allow_inf_nan=False, json_schema_extra={"maximum": _LONGEST_M}),
    _up_to(_LONGEST_M, "m"),
]
Place = Annotated[
    float,
    Field(allow_inf_nan=False, json_schema_extra={"minimum": -_LONGEST_M, "maximum": _LONGEST_M}),
    _up_to(_LONGEST_M, "m"),
]
Distance = Annotated[
    float,
    Field(gt=0, allow_inf_nan=False, json_schema_extra={"maximum": _FARTHEST_M}),
    _up_to(_FARTHEST_M, "m"),
]
Speed = Annotated[
    float,
    Field(gt=0, allow_inf_nan=False, json_schema_extra={"maximum": _FASTEST_M_S}),
    _up_to(_FASTEST_M_S, "m/s"),
]
Mass = Annotated[
    float,
    Field(gt=0, allow_inf_nan=False, json_schema_extra={"maximum": _HEAVIEST_KG}),
    _up_to(_HEAVIEST_KG, "kg"),
]
Point2 = tuple[Place, Place]
Point3 = tuple[Place, Place, Place]
Extent3 = tuple[Length, Length, Length]
Size3 = tuple[Positive, Positive, Positive]


class RobotPart(BaseModel):
    """Figures of a part: immutable, without unknown keys."""

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)
