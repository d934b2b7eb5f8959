"""Behaviours written in Python."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, ClassVar

from pydantic import Field, PlainValidator
from typing_extensions import override

from bt_mission.language.expressions.expression import Expression
from bt_mission.language.nodes import fields
from bt_mission.language.nodes.base import (
    Read,
)
from bt_mission.language.nodes.fields import (
    TEXT_SCHEMA,
    Computed,
    Variable,
)
from bt_mission.language.nodes.interface import (
    OutputsNode,
    shown_fields,
)


class PythonNode(OutputsNode):
    """A behaviour written in Python."""

    # "module:Class", "file.py:Class", or the name of a plug-in. `inputs` become attributes of it
    # whenever it is entered; `outputs` takes attributes.
    kind: ClassVar[str] = "python"

    target: Annotated[str, PlainValidator(fields.python_target), TEXT_SCHEMA] = Field(
        alias="python"
    )
    inputs: dict[Variable, Computed] = {}
    outputs: dict[Variable, Variable] = {}

    @override
    def reads(self) -> Iterator[Read]:
        for name, value in self.inputs.items():
            if isinstance(value, Expression):
                yield Read(("inputs", name), value)

    @property
    @override
    def default_label(self) -> str:
        return self.target.rpartition(":")[2]

    @override
    def details(self) -> list[str]:
        return [self.target, *shown_fields(self.inputs), *self.shown_outputs()]
