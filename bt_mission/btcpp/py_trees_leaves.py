"""Our leaves with ports, for py_trees' own XML loader (``py_trees.parsers``).

The loader makes them from the elements and attributes of `docs/how-to/groot.md`, wires `{name}`
to py_trees' blackboard, and hands over anything else as a string, which means here what it means in
a mission. Each leaf is the leaf that a mission would have.
"""

from __future__ import annotations

import itertools
import types
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, cast

from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.ports import (
    CONST_PREFIX,
    NoDataAvailable,
    PortInformation,
    PortsMixin,
    decode_const_value,
)
from typing_extensions import override

from bt_mission.behaviours.builder import build_tree
from bt_mission.behaviours.runtime import MissionFailure, Runtime, Scope
from bt_mission.btcpp.elements import Attribute, Element
from bt_mission.btcpp.leaves import LEAVES, LeafElement, read_leaf
from bt_mission.btcpp.palette import field_ports
from bt_mission.core.diagnostics import Diagnostic, InputError
from bt_mission.core.errors import BtMissionError
from bt_mission.core.yaml.composer import Place
from bt_mission.core.yaml.document import Document
from bt_mission.language.checks.mission import type_faults
from bt_mission.language.checks.types import FindShapes
from bt_mission.language.loader import draft
from bt_mission.language.message_types import Scalar, Shape

NEEDS_NAMES = frozenset(("set", "python"))
"""Leaves whose attributes are named by their users, so that no class can declare their ports."""

VARIABLE = "port_"
"""Begins the variable that holds the value of a port."""

_ANY = str | bool | int | float | list[Any]
_TYPES: Mapping[str, Any] = {
    "number": float | int | str,
    "integer": int | str,
    "bool": bool | str,
    "text": str,
}


@dataclass(frozen=True)
class _Known:
    """What the leaves of one registry share: what ROS types hold, and a seed for each leaf."""

    shapes: FindShapes | None
    seeds: Iterator[int]


class PortLeaf(PortsMixin, Behaviour):
    """A leaf of a mission, its attributes ports.

    What is wrong with its constants is raised in `setup`, and with what comes from the blackboard
    when it is entered.
    """

    leaf: ClassVar[LeafElement]

    _known: ClassVar[_Known]

    def __init__(
        self, name: str, *, behaviour_class_name: str | None = None, **constants: str
    ) -> None:
        super().__init__(name=name, behaviour_class_name=behaviour_class_name)
        self._constants = constants
        self._given: dict[str, str | None] = {}
        self._scope = Scope({}, next(self._known.seeds))
        self._inner: Behaviour | None = None
        self._runtime: Runtime

    @override
    def setup_ports(
        self,
        port_remappings: dict[str, str] | None = None,
        subtree_namespace: str = "/",
        logger: Any = None,
    ) -> None:
        """Note which ports are given, and which of them by constants."""
        given = port_remappings or {}
        self._given = {
            port: decode_const_value(key) if CONST_PREFIX in key else None
            for port, key in given.items()
        }
        super().setup_ports(given, subtree_namespace, logger)

    @property
    def _read(self) -> list[str]:
        """The ports that are read from the blackboard."""
        return [
            port for port, text in self._given.items() if text is None and port in self.INPUT_PORTS
        ]

    def setup(self, **kwargs: Any) -> None:
        """Take the runtime; a leaf of constants is made here, once."""
        self._runtime = kwargs["runtime"]
        if not self._read:
            self._make({})

    def initialise(self) -> None:
        """Read the ports, and forget what was given at the last end.

        Raises:
            MissionFailure: When what they give does not fit.
        """
        if not self._read:
            self._scope.values.clear()
            return
        try:
            self._make({f"{VARIABLE}{port}": self.get_input(port) for port in self._read})
        except (BtMissionError, LookupError, NoDataAvailable, TypeError) as error:
            raise MissionFailure(f"'{self.name}' cannot start: {error}") from error

    def update(self) -> Status:
        """Tick the leaf; write the output ports when it has ended."""
        assert self._inner is not None
        for _ in self._inner.tick():
            pass
        self.feedback_message = self._inner.feedback_message
        if self._inner.status is not Status.RUNNING:
            for port in self._given:
                variable = f"{VARIABLE}{port}"
                if port in self.OUTPUT_PORTS and variable in self._scope.values:
                    self._set_output(port, self._scope.values[variable])
        return self._inner.status

    def terminate(self, new_status: Status) -> None:
        """Halt the leaf with the tree."""
        if new_status is Status.INVALID and self._inner is not None:
            self._inner.stop(Status.INVALID)

    def _make(self, values: Mapping[str, Any]) -> None:
        """Make the leaf for these values of ports."""
        faults: list[Diagnostic] = []

        def report(at: tuple[int, int], message: str, hint: str | None = None) -> None:
            faults.append(Diagnostic(message, self.name, *at, hint=hint))

        element = Element(self.leaf.kind, (0, 0), dict(self._attributes()))
        part = read_leaf(self.leaf, element, report)
        if faults:
            raise InputError(faults)
        data = {"mission": self.name[:200], "inputs": values, "tree": part.data}
        found = draft(Document(self.name, data, Place(0, 0, keys={}, parts={}), ()))
        if found.faults or found.mission is None:
            raise InputError(found.faults)
        if self._known.shapes is not None:
            faults += type_faults(found.mission, self._known.shapes)
        if faults:
            raise InputError(faults)
        self._scope.values.clear()
        self._scope.values.update(values)
        self._inner = build_tree(found.mission, self._scope)
        self._inner.name = self.name
        self._inner.setup(runtime=self._runtime)

    def _attributes(self) -> Iterator[tuple[str, Attribute]]:
        for port, text in {**self._given, **self._constants}.items():
            value = f"{{{VARIABLE}{port}}}" if text is None else text
            yield port, Attribute(port, value, (0, 0), (0, 0))


def leaf_classes(shapes: FindShapes | None, seed: int) -> dict[str, type[PortLeaf]]:
    """Return the classes of all leaves by their tags.

    Without `shapes`, fields of goals take constants only, and there are no outputs.
    """
    known = _Known(shapes, itertools.count(seed * 100_003))
    return {
        kind: _class_of(leaf, known) for kind, leaf in LEAVES.items() if kind not in NEEDS_NAMES
    }


def _class_of(leaf: LeafElement, known: _Known) -> type[PortLeaf]:
    inputs: dict[str, PortInformation] = {}
    outputs: dict[str, PortInformation] = {}
    for name in (*([leaf.whole] if leaf.whole else []), *leaf.settings):
        inputs[name] = PortInformation(data_type=_ANY)
    for name in leaf.modifiers:
        inputs[name] = PortInformation(data_type=_ANY, required=False)
    fields, given = field_ports(leaf, known.shapes)
    for attribute, shape in fields.items():
        inputs[attribute] = PortInformation(data_type=_type(shape), required=False)
    for attribute in given:
        outputs[attribute] = PortInformation(data_type=object, required=False)
    body = {
        "__doc__": f"A leaf '{leaf.kind}'.",
        "leaf": leaf,
        "INPUT_PORTS": inputs,
        "OUTPUT_PORTS": outputs,
        "_known": known,
    }
    name = "".join(word.capitalize() for word in leaf.kind.split("_"))
    made = types.new_class(name, (PortLeaf,), {"register": False}, lambda space: space.update(body))
    return cast("type[PortLeaf]", made)


def _type(shape: Shape) -> Any:
    return _TYPES[shape.type] if isinstance(shape, Scalar) else str | list
