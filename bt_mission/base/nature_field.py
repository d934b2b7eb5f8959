"""The field ``nature`` of a file: a profile, or a mapping with numbers."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from typing import Annotated, Any, TypeAlias

from pydantic import PlainSerializer, PlainValidator, WithJsonSchema
from pydantic_core import PydanticCustomError

from bt_mission.base.diagnostics import describe, did_you_mean, listed, quoted
from bt_mission.base.nature import BY_NAME, PROFILES, QUANTITIES, Nature, NatureQuantity, Profile
from bt_mission.base.units import UNITS, converted


def read_nature(written: Any) -> Nature:
    """Return the nature in a file: a profile, or a mapping with numbers.

    Raises:
        PydanticCustomError: With the error.
    """
    if isinstance(written, Nature):
        return written
    if isinstance(written, str):
        return Nature(_profile(written))
    if not isinstance(written, Mapping):
        raise _refused(f"expected one of {listed(PROFILES)}, or a mapping, got {describe(written)}")
    numbers = {str(name): value for name, value in written.items() if name != "profile"}
    return Nature(
        _profile(written.get("profile", "none")),
        {name: _number(name, value) for name, value in numbers.items()},
    )


def _profile(written: Any) -> Profile:
    for profile in PROFILES:
        if profile == written:
            return profile
    message = f"expected a profile of {listed(PROFILES)}, got {describe(written)}"
    raise _refused(message, did_you_mean(str(written), PROFILES), "BT-303")


def _number(name: str, written: Any) -> float:
    if name not in BY_NAME:
        names = tuple(BY_NAME)
        message = f"unknown quantity {quoted(name)} (known: {listed(names, len(names))})"
        raise _refused(message, did_you_mean(name, names), "BT-201")
    quantity = BY_NAME[name]
    value = _in_unit(quantity, written)
    if not quantity.least <= value <= quantity.most:
        limits = f"{quantity.least:g} to {quantity.most:g} {quantity.unit}".rstrip()
        raise _refused(f"{name}: expected {limits}, got {describe(written)}", code="BT-302")
    return value


def _in_unit(quantity: NatureQuantity, written: Any) -> float:
    """Return a number in the quantity's unit: a plain number, or a text such as ``2 cm``."""
    if isinstance(written, int | float) and not isinstance(written, bool):
        return float(written)
    base = UNITS[quantity.unit][1] if quantity.unit in UNITS else None
    units = [name for name, (_, other) in UNITS.items() if other == base] or [quantity.unit]
    if isinstance(written, str):
        number, _, unit = written.strip().partition(" ")
        with suppress(ValueError):
            if unit.strip() in units and unit:
                value = float(number)
                return value if base is None else converted(value, unit.strip(), quantity.unit)
    expected = f"a number, or one with a unit of {listed(units)}" if quantity.unit else "a number"
    raise _refused(f"{quantity.name}: expected {expected}, got {describe(written)}")


def _refused(message: str, hint: str | None = None, code: str = "BT-301") -> PydanticCustomError:
    context = {"message": message, "hint": hint, "offset": None, "code": code}
    return PydanticCustomError("refused", "{message}", context)


def _schema() -> dict[str, Any]:
    numbers: dict[str, Any] = {
        quantity.name: {
            "description": f"{quantity.text}; in {quantity.unit}"
            if quantity.unit
            else quantity.text,
            "type": ["number", "string"] if quantity.unit else "number",
        }
        for quantity in QUANTITIES
    }
    properties = {"profile": {"enum": list(PROFILES)}, **numbers}
    mapping = {"type": "object", "properties": properties, "additionalProperties": False}
    return {"anyOf": [{"enum": list(PROFILES)}, mapping]}


WrittenNature: TypeAlias = Annotated[
    Nature,
    PlainValidator(read_nature),
    PlainSerializer(lambda profile: profile.written),
    WithJsonSchema(_schema()),
]
"""The field of a file's model."""
