"""The kinds of leaf that speak to nobody, and those that are written in Python."""

from collections.abc import Iterator
from typing import Annotated, ClassVar

from pydantic import Field, PlainValidator
from typing_extensions import override

from bt_mission.language.expressions.expression import written_text
from bt_mission.language.nodes import base, fields


class CheckNode(base.ConditionalNode):
    """Success where a condition holds, else failure."""

    kind: ClassVar[str] = "check"
    sign: ClassVar[base.Sign] = base.Sign("◇", "<>", "check", base.Family.CONDITION)

    condition: fields.Condition = Field(alias="check")

    @override
    def ends(self, _below: list[base.Ends]) -> base.Ends:
        if isinstance(self.condition, bool):
            return base.SUCCESS if self.condition else base.FAILURE
        return base.EITHER


class SetNode(base.NodeModel):
    """New values for variables."""

    # One after another: each value may read those before it.
    kind: ClassVar[str] = "set"
    sign: ClassVar[base.Sign] = base.Sign("≔", ":=", "set", base.Family.OTHER)
    always: ClassVar[base.Ends] = base.SUCCESS

    values: Annotated[dict[fields.Variable, fields.Computed], Field(min_length=1)] = Field(
        alias="set"
    )

    @override
    def reads(self) -> Iterator[base.Read]:
        for read, name in zip(super().reads(), self.values, strict=True):
            yield read._replace(assigns=name)

    @override
    def writes(self) -> Iterator[base.Write]:
        for name, value in self.values.items():
            yield base.Write(("set", name), name, "variable", value=value)

    @override
    def default_label(self) -> str:
        return f"set {', '.join(self.values)}"

    @override
    def details(self) -> list[str]:
        return [f"{name} = {written_text(value)}" for name, value in self.values.items()]


class WaitNode(base.NodeModel):
    """Nothing, for some seconds."""

    kind: ClassVar[str] = "wait"
    sign: ClassVar[base.Sign] = base.Sign("◷", "t", "wait", base.Family.OTHER)
    always: ClassVar[base.Ends] = base.SUCCESS
    takes_time: ClassVar[bool] = True

    seconds: fields.Seconds = Field(alias="wait")

    @override
    def details(self) -> list[str]:
        return [f"{written_text(self.seconds)} s"]


class LogNode(base.NodeModel):
    """A line in the log."""

    kind: ClassVar[str] = "log"
    sign: ClassVar[base.Sign] = base.Sign("¶", '"', "log", base.Family.OTHER)
    always: ClassVar[base.Ends] = base.SUCCESS

    message: fields.Message = Field(alias="log")

    @override
    def details(self) -> list[str]:
        return [self.message.text]


class PythonNode(base.OutputsNode):
    """A behaviour written in Python."""

    # "module:Class", "file.py:Class", or the name of a plug-in. `inputs` become attributes of it
    # whenever it is entered; `outputs` takes attributes.
    kind: ClassVar[str] = "python"
    fixed: ClassVar[tuple[str, ...]] = ("target",)
    sign: ClassVar[base.Sign] = base.Sign("λ", "py", "python", base.Family.OTHER)

    target: Annotated[str, PlainValidator(fields.python_target), fields.TEXT_SCHEMA] = Field(
        alias="python"
    )
    inputs: dict[fields.Variable, fields.Computed] = {}
    outputs: dict[fields.Variable, fields.Variable] = {}

    @override
    def default_label(self) -> str:
        return self.target.rpartition(":")[2]

    @override
    def details(self) -> list[str]:
        return [self.target, *base.shown_fields(self.inputs), *self.shown_outputs()]
