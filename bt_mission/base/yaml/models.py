"""From data to pydantic models; errors of pydantic become diagnostics with places."""

from __future__ import annotations

import json
import types
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import reduce
from operator import getitem
from typing import Annotated, Any, Literal, TypeVar, Union, get_args, get_origin

import pydantic
from pydantic_core import ErrorDetails

from bt_mission.base.diagnostics import (
    MOST_DIAGNOSTICS,
    Diagnostic,
    InputError,
    describe,
    did_you_mean,
    listed,
    quoted,
)
from bt_mission.base.yaml.document import Document, Key

Model = TypeVar("Model", bound=pydantic.BaseModel)

_EXPECTED = {
    **dict.fromkeys(("bool_parsing", "bool_type"), "a boolean"),
    **dict.fromkeys(("dict_type", "mapping_type"), "a mapping"),
    **dict.fromkeys(("model_attributes_type", "model_type"), "a mapping"),
    **dict.fromkeys(("float_parsing", "float_type"), "a number"),
    **dict.fromkeys(("int_from_float", "int_parsing", "int_type"), "an integer"),
    **dict.fromkeys(("list_type", "tuple_type"), "a list"),
    "finite_number": "a finite number",
    "string_type": "a string",
}
_BOOLEANS = {"yes": "true", "on": "true", "y": "true", "no": "false", "off": "false", "n": "false"}


def word_for_boolean(value: Any) -> str | None:
    """Return a hint if a value is a word that older YAML takes for a boolean, or None."""
    word = _BOOLEANS.get(value.lower()) if isinstance(value, str) else None
    return word and f"in YAML 1.2 a boolean is written '{word}'"


_LIMITS = {
    "greater_than": "more than {gt}",
    "greater_than_equal": "at least {ge}",
    "less_than": "less than {lt}",
    "less_than_equal": "at most {le}",
    "multiple_of": "a multiple of {multiple_of}",
    "string_pattern_mismatch": "a string of the form {pattern}",
    "string_too_long": "at most {max_length} characters",
    "string_too_short": "at least {min_length} characters",
    "too_long": "a list of at most {max_length}",
    "too_short": "a list of at least {min_length}",
}


def validate(document: Document, model: type[Model], path: Sequence[Key] = ()) -> Model:
    """Return the part of a document at `path` as a model. Raises InputError with all errors.

    Types are taken strictly: no number from a text, no truth from a number.
    """
    data = reduce(getitem, path, document.data)
    try:
        # As JSON, because only there a strict model takes a list for a tuple.
        return model.model_validate_json(json.dumps(data), strict=True)
    except pydantic.ValidationError as error:
        raise InputError(model_diagnostics(document, error, model, path)) from error


def model_diagnostics(
    document: Document, error: pydantic.ValidationError, model: Any, path: Sequence[Key] = ()
) -> list[Diagnostic]:
    """Return a pydantic error as diagnostics, in the order of the file, one for each place."""
    merged: dict[tuple[int, int, str], Diagnostic] = {}
    for detail in error.errors(include_url=False)[:MOST_DIAGNOSTICS]:
        if detail["type"] == "too_short" and len(detail["input"]) >= detail["ctx"]["min_length"]:
            continue  # pydantic does not count items that have an error of their own
        each = _diagnostic(document, detail, model, path)
        is_type = each.message.startswith("expected")
        what = (each.line, each.column, "" if is_type else each.message)
        merged[what] = _merged(merged[what], each) if what in merged else each
    return sorted(merged.values(), key=lambda each: (each.line, each.column))


def _merged(earlier: Diagnostic, other: Diagnostic) -> Diagnostic:
    """Return the errors of two members of a union as one: "expected a or b, got c"."""
    first, separator, got = earlier.message.partition(", got ")
    second, _, other_got = other.message.partition(", got ")
    if not separator or got != other_got or second in first:
        return earlier
    message = f"{first} or {second.removeprefix('expected ')}, got {got}"
    return replace(earlier, message=message)


def _diagnostic(
    document: Document, detail: ErrorDetails, model: Any, path: Sequence[Key]
) -> Diagnostic:
    where, names = _in_document(document, detail["loc"], model, path)
    kind, got = detail["type"], describe(detail["input"])
    context: Mapping[str, Any] = detail.get("ctx", {})
    last = detail["loc"][-1] if detail["loc"] else ""
    if kind == "missing":
        return document.diagnostic("BT-202", where, f"{quoted(str(last))} is missing")
    if kind == "union_tag_not_found":
        return document.diagnostic("BT-202", where, f"{context['discriminator']} is missing")
    if kind == "union_tag_invalid":
        valid = [name.strip("'") for name in str(context["expected_tags"]).split(", ")]
        tag = str(context["tag"])
        place = (*where, str(context["discriminator"]).strip("'"))
        message = f"expected one of {listed(valid)}, got {quoted(tag)}"
        return document.diagnostic("BT-303", place, message, did_you_mean(tag, valid))
    if kind == "extra_forbidden":
        message = f"unknown key {quoted(str(last))} (valid: {listed(names)})"
        return document.diagnostic(
            "BT-201", where, message, did_you_mean(str(last), names), key=True
        )
    if kind in _LIMITS:
        return document.diagnostic(
            "BT-302", where, f"expected {_LIMITS[kind].format(**context)}, got {got}"
        )
    if kind in _EXPECTED:
        hint = word_for_boolean(detail["input"]) if kind.startswith("bool") else None
        if kind in ("dict_type", "mapping_type") and isinstance(detail["input"], list):
            hint = "write 'NAME: VALUE' for each, without '- '"
        return document.diagnostic("BT-301", where, f"expected {_EXPECTED[kind]}, got {got}", hint)
    if kind in ("literal_error", "enum"):
        literals = str(context["expected"]).replace(" or ", ", ").split(", ")
        valid = [name.strip("'") for name in literals]
        hint = did_you_mean(str(detail["input"]), valid)
        return document.diagnostic(
            "BT-303", where, f"expected one of {listed(valid)}, got {got}", hint
        )
    message = detail["msg"].removeprefix("Value error, ")
    offset = context.get("offset")
    code = context.get("code", "BT-307")
    is_key = last == "[key]"
    return document.diagnostic(code, where, message, context.get("hint"), key=is_key, offset=offset)


def _in_document(
    document: Document, loc: tuple[Key, ...], model: Any, path: Sequence[Key]
) -> tuple[tuple[Key, ...], list[str]]:
    """Return the path in the document of pydantic's location, and the names valid there.

    pydantic puts the names of union members into its locations; parts that are not in the document
    are omitted.
    """
    where: list[Key] = list(path)
    data = reduce(getitem, path, document.data)
    kinds = [model]
    names: list[str] = []
    for key in loc:
        if isinstance(data, dict) and key in data:
            names = sorted({name for kind in kinds for name in _fields(kind)})
        elif not (isinstance(data, list) and isinstance(key, int) and key < len(data)):
            kinds = [kind for kind in kinds if key in _tags(kind)] or kinds
            continue
        kinds = [inner for kind in kinds for inner in _inner(kind, key)]
        where.append(key)
        data = data[key]
    return tuple(where), names


def _tags(kind: Any) -> Iterator[Any]:
    """Return the names that pydantic may give to a member of a union in its locations."""
    yield getattr(kind, "__name__", None)
    if isinstance(kind, type) and issubclass(kind, pydantic.BaseModel):
        for field in kind.model_fields.values():
            if get_origin(field.annotation) is Literal:
                yield from get_args(field.annotation)


def _fields(kind: Any) -> list[str]:
    if isinstance(kind, type) and issubclass(kind, pydantic.BaseModel):
        return [field.alias or name for name, field in kind.model_fields.items()]
    return []


def _inner(kind: Any, key: Key) -> Iterator[Any]:
    """Return the types that a part of a value of this type may have."""
    if isinstance(kind, type) and issubclass(kind, pydantic.BaseModel):
        for name, field in kind.model_fields.items():
            if key in (name, field.alias):
                yield from _members(field.annotation)
        return
    arguments = get_args(kind)
    if get_origin(kind) in (list, tuple, Sequence) and arguments:
        yield from _members(arguments[0])
    elif get_origin(kind) in (dict, Mapping) and len(arguments) == 2:
        yield from _members(arguments[1])


def _members(annotation: Any) -> Iterator[Any]:
    """Return the members of a union, an annotated type's own type, or the type itself."""
    origin = get_origin(annotation)
    if origin is Annotated:
        yield from _members(get_args(annotation)[0])
    elif origin in (Union, types.UnionType):
        for member in get_args(annotation):
            yield from _members(member)
    elif origin is not Literal:
        yield annotation
