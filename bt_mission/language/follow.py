"""Variables that follow a topic: each holds the newest value of one field of its messages."""

from dataclasses import dataclass
from typing import Annotated

from pydantic import Field, PlainValidator

from bt_mission.language.nodes import fields
from bt_mission.language.nodes.base import InFile, NodePlace, Written


class FollowSettings(Written):
    """A field of a topic, and the variable that follows it. Times are seconds of ROS time."""

    topic: Annotated[str, PlainValidator(fields.topic_name), fields.TEXT_SCHEMA]
    type: Annotated[str, PlainValidator(fields.message_type), fields.TEXT_SCHEMA]
    field: Annotated[str, PlainValidator(fields.message_field), fields.TEXT_SCHEMA]
    variable: fields.Variable = Field(alias="as")
    initial: fields.InputValue = None
    default: fields.InputValue = None
    timeout: fields.FixedLimit | None = None


@dataclass(frozen=True)
class Follow(InFile):
    """A variable that follows a topic, as a mission or a named tree has it at its head.

    Args:
        settings: What is written there.
        file: In which it stands.
        place: Of it in that file.
    """

    settings: FollowSettings
    file: str
    place: NodePlace

    @property
    def variable(self) -> str:
        """The name of the variable."""
        return self.settings.variable

    @property
    def type(self) -> str:
        """The full name of the type of the topic."""
        return self.settings.type
