"""The use of a named tree."""

from collections.abc import Iterator, Mapping
from functools import cached_property
from typing import Annotated, Any, ClassVar, Self

from pydantic import BeforeValidator, Field, WithJsonSchema
from typing_extensions import override

from bt_mission.base.diagnostics import describe, did_you_mean, listed, quoted
from bt_mission.language.expressions.expression import Expression
from bt_mission.language.expressions.values import WORDS, Type, fits, type_of
from bt_mission.language.nodes import base, fields


class TreeSettings(base.Written):
    """A named tree, and values for its inputs."""

    name: fields.TreeName
    inputs: dict[fields.Variable, fields.Computed] = {}


class TreeNode(base.OutputsNode):
    """A tree that has a name."""

    # The body of the tree is not below this node: a tree stands by itself.
    kind: ClassVar[str] = "tree"
    fixed: ClassVar[tuple[str, ...]] = ("tree", "outputs")
    sign: ClassVar[base.Sign] = base.Sign("▣", "[]", "tree", base.Family.SUBTREE)

    settings: Annotated[
        TreeSettings,
        BeforeValidator(fields.tree_use),
        WithJsonSchema({"type": ["string", "object"]}),
    ] = Field(alias="tree")
    outputs: dict[fields.Variable, fields.Variable] = {}
    takes: base.Hidden[Mapping[str, Type | None]] = Field({}, alias="@takes")
    """The types of the inputs of the tree, by their names; the reader knows them."""
    gives: base.Hidden[Mapping[str, Type]] = Field({}, alias="@gives")
    """The types of its outputs."""

    @property
    def tree(self) -> str:
        """The name of the tree."""
        return self.settings.name

    @property
    def inputs(self) -> Mapping[str, Any]:
        """The values for its inputs."""
        return self.settings.inputs

    @cached_property
    def live_inputs(self) -> Mapping[str, str]:
        """The inputs that are a variable of the caller, with that variable.

        They have its value of each tick. One that the tree itself writes, by an output, keeps the
        value at entry: an input of a tree never changes by what the tree does.
        """
        named = {
            name: value.variable
            for name, value in self.inputs.items()
            if isinstance(value, Expression) and value.variable is not None
        }
        own = set(self.outputs.values())
        return {name: variable for name, variable in named.items() if variable not in own}

    @override
    def completed(self, reading: base.Reading) -> Self:
        """Return the node with the types of what the tree takes and gives."""
        path = (*self.path, "tree")
        name_path = (*path, "name") if reading.document.find(path).keys else path
        signature = reading.signatures.get(self.tree)
        if signature is None:
            known = listed(reading.signatures)
            message = f"unknown tree {quoted(self.tree)} (trees: {known})"
            reading.report(
                "BT-210", name_path, message, did_you_mean(self.tree, reading.signatures)
            )
            return self
        definition = signature.definition
        self._compare_inputs(signature.types, path, reading)
        missing = [name for name in definition.needs if name not in self.inputs]
        if missing:
            message = f"{self.tree} needs a value for {listed(missing)}"
            reading.report("BT-212", name_path, message, "give it under 'inputs'")
        gives = definition.outputs
        for result in self.outputs:
            if result not in gives and not reading.is_full:
                message = f"{self.tree} has no output {quoted(result)} (outputs: {listed(gives)})"
                hint = did_you_mean(result, gives)
                reading.report("BT-212", (*self.path, "outputs", result), message, hint, key=True)
        return self.model_copy(update={"takes": signature.types, "gives": gives})

    def _compare_inputs(
        self, takes: Mapping[str, Type | None], path: base.Path, reading: base.Reading
    ) -> None:
        for given, value in self.inputs.items():
            if reading.is_full:
                break
            place = (*path, "inputs", given)
            if given not in takes:
                message = f"{self.tree} has no input {quoted(given)} (inputs: {listed(takes)})"
                reading.report("BT-212", place, message, did_you_mean(given, takes), key=True)
            elif not isinstance(value, Expression):
                wanted = takes[given]
                if wanted is not None and not fits(type_of(value), wanted):
                    reading.report(
                        "BT-212", place, f"expected {WORDS[wanted]}, got {describe(value)}"
                    )

    @override
    def reads(self) -> Iterator[base.Read]:
        for read in super().reads():
            yield read._replace(wanted=self.takes.get(str(read.path[-1])))

    @override
    def writes(self) -> Iterator[base.Write]:
        for source, variable in self.outputs.items():
            yield base.Write(("outputs", source), variable, type=self.gives.get(source))

    @override
    def default_label(self) -> str:
        return self.tree

    @override
    def details(self) -> list[str]:
        return [*base.shown_fields(self.inputs), *self.shown_outputs()]
