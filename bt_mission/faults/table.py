"""The table of faults: what each is called and takes, read from the methods that make them.

The fixtures of tests, the text form, files, their schema, completion and the documentation all
have their faults from here.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

from bt_mission.faults.parameters import Named, OneOf, ParameterUnit

Form = Literal["number", "integer", "flag", "text", "numbers", "anything"]
"""What is written for an argument."""


@dataclass(frozen=True)
class FaultParameter:
    """One argument of a fault, as it can be written.

    Attributes:
        form: What is written.
        text: What it is for; empty where the name says all.
        unit: Of a number, or of each of several.
        names: Of what in the graph a text is the name.
        choices: The texts that it can be; empty where any will do.
        count: How many numbers belong together.
        is_required: The fault cannot do without it.
        by_position: It can be given without its name.
        repeats: It can be given several times, by position alone.
    """

    name: str
    form: Form
    text: str = ""
    unit: str = ""
    names: str = ""
    choices: tuple[str, ...] = ()
    count: int = 1
    is_required: bool = False
    by_position: bool = False
    repeats: bool = False
    is_on: bool = False
    """Of a flag: whether it is on where it is left out."""

    @property
    def usage(self) -> str:
        """How it is written: ``<by s>`` by position, ``[jitter s]`` by its name."""
        if self.form == "flag":
            return f"[{self.name} false]" if self.is_on else f"[{self.name}]"
        value = self.unit or ("N" if self.form in ("number", "integer") else self.name.upper())
        if self.choices:
            value = "|".join(f'"{name}"' if " " in name else name for name in self.choices)
        if self.form == "numbers":
            value = f"({', '.join([self.unit] * self.count)})"
        if self.by_position and (self.choices or self.form not in ("number", "integer")):
            written = value
        elif self.by_position:
            written = f"<{self.name} {self.unit}>" if self.unit else f"<{self.name}>"
        else:
            written = f"{self.name} {value}"
        written = written if self.is_required else f"[{written}]"
        return f"{written}..." if self.repeats else written

    @property
    def expected(self) -> str:
        """What is written for it, in words."""
        of = f" in {self.unit}" if self.unit else ""
        if self.choices:
            return f"one of {', '.join(self.choices)}"
        forms: dict[Form, str] = {
            "number": f"a number{of}",
            "integer": "an integer",
            "flag": "true or false",
            "text": f"the name of a {self.names}" if self.names else "a text",
            "numbers": f"{self.count} numbers{of}, such as ({', '.join(['0.5'] * self.count)})",
            "anything": "a value",
        }
        return forms[self.form].replace("a action", "an action")


@dataclass(frozen=True)
class FaultKind:
    """A fault that can be written down.

    Attributes:
        text: What it does.
        parameters: By their names, in order, without `lasting`.
        lasts: It goes on for a while; else it is over at once.
        takes_fields: It takes further arguments of any name.
    """

    name: str
    text: str
    parameters: Mapping[str, FaultParameter]
    lasts: bool
    takes_fields: bool

    @property
    def usage(self) -> str:
        """How it is written: ``drop TOPIC [share N] [every N] [lasting s]``."""
        parts = [self.name, *(one.usage for one in self.parameters.values())]
        parts += ["[FIELD=VALUE]..."] if self.takes_fields else []
        parts += ["[lasting s]"] if self.lasts else []
        return " ".join(parts)


LASTING = FaultParameter("lasting", "number", "For how long; to the end where it is left out.", "s")


def fault_kinds(made_by: type) -> Mapping[str, FaultKind]:
    """Return the faults that the methods of a class make, by their names."""
    found: dict[str, FaultKind] = {}
    for base in made_by.__mro__[1:]:
        for name, method in vars(base).items():
            declared = getattr(method, "__wrapped__", None)
            if declared is not None:
                found[name] = _kind(declared)
    return MappingProxyType(found)


def _kind(method: Callable[..., Any]) -> FaultKind:
    signature = inspect.signature(method)
    hints = get_type_hints(method, include_extras=True)
    texts = _arguments_of(inspect.getdoc(method) or "")
    found: dict[str, FaultParameter] = {}
    for one in list(signature.parameters.values())[1:]:
        if one.name == "lasting" or one.kind is one.VAR_KEYWORD:
            continue
        form = _form(hints[one.name])
        if form is not None:
            found[one.name] = FaultParameter(
                one.name,
                text=texts.get(one.name, ""),
                is_required=one.default is one.empty and one.kind is not one.VAR_POSITIONAL,
                is_on=one.default is True,
                by_position=one.kind is not one.KEYWORD_ONLY,
                repeats=one.kind is one.VAR_POSITIONAL,
                **form,
            )
    return FaultKind(
        name=method.__name__,
        text=(inspect.getdoc(method) or "").partition("\n\n")[0].replace("\n", " "),
        parameters=MappingProxyType(found),
        lasts="lasting" in signature.parameters,
        takes_fields=any(one.kind is one.VAR_KEYWORD for one in signature.parameters.values()),
    )


def _form(hint: Any) -> dict[str, Any] | None:
    """Return what is written for a type; None for what only Python can give."""
    if hint is Any:
        return {"form": "anything"}
    plain = {float: "number", int: "integer", bool: "flag", str: "text"}
    if hint in plain:
        return {"form": plain[hint]}
    origin, parts = get_origin(hint), get_args(hint)
    if origin in (Union, UnionType):
        return next((form for part in parts if (form := _form(part))), None)
    if origin is Literal:
        return {"form": "text", "choices": parts}
    if origin is tuple:
        return {**(_form(parts[0]) or {}), "form": "numbers", "count": len(parts)}
    if origin is Annotated:
        return {**(_form(parts[0]) or {}), **dict(_marks(parts[1:]))}
    return None


def _marks(marks: tuple[Any, ...]) -> Iterator[tuple[str, Any]]:
    for mark in marks:
        match mark:
            case ParameterUnit(unit=unit):
                yield "unit", unit
            case Named(kind=kind):
                yield "names", kind
            case OneOf(names=names):
                yield "choices", names


def _arguments_of(docstring: str) -> dict[str, str]:
    """Return what a docstring says of each argument."""
    _, _, section = docstring.partition("Args:\n")
    found = re.findall(r"^    (\w+): (.*(?:\n {6,}.*)*)", section, re.MULTILINE)
    return {name: re.sub(r"\s+", " ", text) for name, text in found}
