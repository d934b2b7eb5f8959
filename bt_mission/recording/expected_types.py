"""Whether a file defines the types of its topics as they are installed."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache

from bt_mission.cdr.decoder import Decoder, DecodingError
from bt_mission.cdr.definitions import Field, NoDefinitionError, definition_of, parse

_FAMILIES = {
    **dict.fromkeys(("byte", "char"), "an integer"),
    **{f"{sign}int{bits}": "an integer" for sign in ("", "u") for bits in (8, 16, 32, 64)},
    **dict.fromkeys(("float32", "float64"), "a float"),
    **dict.fromkeys(("string", "wstring"), "a text"),
    "bool": "a bool",
}
"""The Python types of basic types; each other type, a message, is a separate family."""
_NAME = re.compile(r"\w+(/\w+){1,2}")


def checked_decoder(type_name: str, definition: str) -> Decoder:
    """Return the decoder of messages by the definition in the file.

    Fields may be fewer or more than installed, as of another version. A field of the same name must
    be of the same kind: a reader does not expect a text in place of a number.

    Raises:
        DecodingError: A definition cannot be read, or contradicts the installed one.
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
    """Return whether a type is installed."""
    return bool(_installed(type_name))


@cache
def _installed(type_name: str) -> Mapping[str, str]:
    """Return the kinds of the fields of an installed type; none of a foreign type."""
    if not _NAME.fullmatch(type_name):
        return {}
    try:
        definition = definition_of(type_name)
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
