"""Whether a file defines the types of its topics as they are known here."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache

from bt_mission.core.cdr.decoder import Decoder, DecodingError
from bt_mission.core.cdr.definitions import (
    Definitions,
    Field,
    NoDefinitionError,
    parse,
    share_folders,
)

_FAMILIES = {
    **dict.fromkeys(("byte", "char"), "an integer"),
    **{f"{sign}int{bits}": "an integer" for sign in ("", "u") for bits in (8, 16, 32, 64)},
    **dict.fromkeys(("float32", "float64"), "a float"),
    **dict.fromkeys(("string", "wstring"), "a text"),
    "bool": "a bool",
}
"""What values of basic types are here; others are messages, each a family of its own."""
_NAME = re.compile(r"\w+(/\w+){1,2}")


def checked_decoder(type_name: str, definition: str) -> Decoder:
    """Return what reads messages by the definition that a file brings along.

    Fields may be fewer or more than here, as of another version. What has the same name has to be
    of the same kind: who reads a message would not expect a text in the place of a number.

    Raises:
        DecodingError: For a definition that cannot be read, or contradicts the installed one.
    """
    decoder = Decoder(type_name, definition)
    for name, fields in decoder.specs.items():
        known = _installed(name or type_name)
        for field in fields:
            expected = known.get(field.name)
            if expected is not None and _kind(field) != expected:
                raise DecodingError(
                    f"its definition of {name or type_name} has {_kind(field)} as '{field.name}', "
                    f"expected {expected}"
                )
    return decoder


def is_installed(type_name: str) -> bool:
    """Is a type known here?"""
    return bool(_installed(type_name))


@cache
def _installed(type_name: str) -> Mapping[str, str]:
    """Return the kinds of the fields of an installed type; none of one of somebody else's."""
    if not _NAME.fullmatch(type_name):
        return {}
    try:
        definition = Definitions(share_folders()).of(type_name)
    except NoDefinitionError:
        return {}
    return {field.name: _kind(field) for field in parse(type_name, definition)[""]}


def _kind(field: Field) -> str:
    family = _FAMILIES.get(field.type, field.type)
    return (
        family
        if field.size is None
        else f"a list of {family.removeprefix('a ').removeprefix('an ')}"
    )
