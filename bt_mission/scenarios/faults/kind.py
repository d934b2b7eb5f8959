"""A row of the table of faults: name, effect, parameters and group; how it is written and made."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias

from bt_mission.scenarios.draws import Draws
from bt_mission.scenarios.faults.drawable import Drawable
from bt_mission.scenarios.faults.errors import ScenarioError
from bt_mission.scenarios.faults.fault import Fault, FaultInstance
from bt_mission.scenarios.faults.parameters import LASTING, MAY_NOT_HAPPEN, Parameter

Arguments: TypeAlias = Mapping[str, Any]
"""The arguments of a fault by their names, defaults included; ``fields`` are those of any name."""

Effect: TypeAlias = Callable[[FaultInstance, Arguments], None]
"""Makes something go wrong, and says how that is undone."""


@dataclass(frozen=True)
class FaultKind:
    """A fault that can be made, and written down where its arguments are data.

    Attributes:
        text: What it does.
        effect: Begins it.
        declared: Its parameters in order, without `lasting`.
        area: Of the reference.
        group: Of the search; those without one are never drawn from a group.
        lasts: It lasts for a while; else it is over at once.
        takes_fields: It takes further arguments of any name, the fields of a message.
        needs_fields: It cannot do without any.
        part: The part of the robot that it breaks.
        check: What is wrong with the arguments together; empty if nothing is.
        draw: Draws its arguments, where the parameters do not each for itself.
        waits: It waits for its call, so a random one has no `lasting`.
    """

    name: str
    text: str
    effect: Effect
    declared: tuple[Parameter, ...] = ()
    area: str = ""
    group: str = ""
    lasts: bool = True
    takes_fields: bool = False
    needs_fields: bool = False
    part: str = ""
    check: Callable[[Arguments], str] = lambda _: ""
    draw: Callable[[Draws, Drawable], Arguments] | None = None
    waits: bool = False

    @cached_property
    def parameters(self) -> Mapping[str, Parameter]:
        """Those that can be written, by their names, without `lasting`."""
        return {
            parameter.name: parameter for parameter in self.declared if parameter.form != "python"
        }

    @cached_property
    def optional(self) -> Mapping[str, Parameter]:
        """All that can be written by their names, with those that every fault has."""
        lasting = {LASTING.name: LASTING} if self.lasts else {}
        return {**self.parameters, **lasting, MAY_NOT_HAPPEN.name: MAY_NOT_HAPPEN}

    @property
    def usage(self) -> str:
        """How it is written: ``drop TOPIC [share N] [every N] [lasting s]``."""
        parts = [self.name, *(parameter.usage for parameter in self.parameters.values())]
        parts += ["[FIELD=VALUE]..."] if self.takes_fields else []
        parts += [LASTING.usage] if self.lasts else []
        return " ".join(parts)

    @cached_property
    def signature(self) -> inspect.Signature:
        """How code calls it."""
        kinds = inspect.Parameter
        signature = [
            kinds(
                parameter.name,
                kinds.VAR_POSITIONAL
                if parameter.repeats
                else kinds.KEYWORD_ONLY
                if parameter.by_name
                else kinds.POSITIONAL_OR_KEYWORD,
                default=parameter.default,
            )
            for parameter in self.declared
        ]
        signature += [kinds("lasting", kinds.KEYWORD_ONLY, default=None)] if self.lasts else []
        signature += [kinds("fields", kinds.VAR_KEYWORD)] if self.takes_fields else []
        return inspect.Signature(signature)

    def make(self, *args: Any, **options: Any) -> Fault:
        """Make the fault.

        Raises:
            ScenarioError: For arguments that it does not take.
            TypeError: Where Python refuses the call of a function with these parameters.
        """
        bound = self.signature.bind(*args, **options)
        bound.apply_defaults()
        given = bound.arguments
        lasting = given.pop("lasting", None)
        for parameter, value in (
            *((parameter, given[parameter.name]) for parameter in self.declared),
            (LASTING, lasting),
        ):
            if not parameter.accepts(value):
                expected = f"expected {parameter.expected} for '{parameter.name}', got {value!r}"
                raise ScenarioError(f"{self.name}: {expected}")
        if self.needs_fields and not given["fields"]:
            raise ScenarioError(f"{self.name}: give fields, such as error_code=906")
        if problem := self.check(given):
            raise ScenarioError(f"{self.name}: {problem}")
        return Fault(
            self.name, self._shown(given), lambda fault: self.effect(fault, given), lasting
        )

    def _shown(self, given: Arguments) -> dict[str, Any]:
        """Return the arguments without those that change nothing."""
        shown = {}
        for parameter in self.declared:
            value = given[parameter.name]
            is_usual = (parameter.is_quiet or not parameter.default) and bool(
                value == parameter.default
            )
            if value is not None and not is_usual and not (parameter.repeats and not value):
                shown[parameter.name] = value
        return {**shown, **given.get("fields", {})}
