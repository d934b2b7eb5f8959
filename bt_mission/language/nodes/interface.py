"""What the kinds of node have in common that use ROS interfaces, or give results."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, ClassVar, Literal

from typing_extensions import override

from bt_mission.language.expressions.expression import Expression, Value, written_text
from bt_mission.language.nodes.base import NodeModel, Path, Write


class OutputsNode(NodeModel):
    """A node with results; `outputs` names the variable that each of them goes to."""

    takes_time: ClassVar[bool] = True

    if TYPE_CHECKING:
        outputs: dict[str, str]

    @override
    def writes(self) -> Iterator[Write]:
        for source, variable in self.outputs.items():
            yield Write(("outputs", source), variable)

    def shown_outputs(self) -> list[str]:
        """Return the outputs as a drawing shows them."""
        return [f"{variable} := {source}" for source, variable in self.outputs.items()]


class InterfaceNode(NodeModel):
    """A node that uses a ROS interface: an action, a service or a topic.

    What it reads of messages are fields, dotted where they are nested.
    """

    interface: ClassVar[Literal["action", "service", "topic"]]
    takes_time: ClassVar[bool] = True

    @property
    def ros_name(self) -> str:
        """The name of the action, service or topic, such as "/turn"."""
        raise NotImplementedError

    @property
    def type(self) -> str:
        """The full name of the type."""
        raise NotImplementedError

    @property
    def type_path(self) -> Path:
        """Where the type stands below the node."""
        return (self.kind, "type")

    @property
    def sent(self) -> Mapping[str, Value]:
        """The fields that it sends, of a goal, a request or a message."""
        return {}

    @property
    def sent_path(self) -> Path:
        """Where those stand below the node."""
        return ()

    @property
    def condition(self) -> Expression | None:
        """The condition on messages that it waits for."""
        return None

    @property
    def condition_path(self) -> Path:
        """Where that stands below the node."""
        return ()

    @property
    @override
    def default_label(self) -> str:
        return self.ros_name.strip("/")

    def called(self) -> list[str]:
        """Return whom it speaks to as a drawing shows it, unless that is the node's label."""
        name = self.ros_name
        return [name if name.startswith("/") else f"/{name}"] if self.name else []


def shown_fields(values: Mapping[str, Any]) -> list[str]:
    """Return fields of a message or inputs as a drawing shows them."""
    return [f"{name} {written_text(value)}" for name, value in values.items()]


def shown_limit(timeout: Value | None) -> list[str]:
    """Return a limit in seconds as a drawing shows it."""
    return [] if timeout is None else [f"within {written_text(timeout)} s"]
