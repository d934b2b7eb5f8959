"""The type of command that the robot subscribes to: pure decisions from the ROS graph.

A TurtleBot3 on Jazzy takes `geometry_msgs/TwistStamped` by default and `geometry_msgs/Twist` with
`enable_stamped_cmd_vel: false`. DDS never delivers one type to a reader of the other, and reports
nothing.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal, TypeAlias

STAMPED = "geometry_msgs/msg/TwistStamped"
PLAIN = "geometry_msgs/msg/Twist"
COMMAND_TYPES = (STAMPED, PLAIN)

Choice: TypeAlias = Literal["auto", "stamped", "plain"]
CHOICES: tuple[Choice, ...] = ("auto", "stamped", "plain")
_CHOSEN = {"stamped": STAMPED, "plain": PLAIN}


class Listeners:
    """The type of command to send, decided once; after that, other types are errors.

    Args:
        topic: Full name of the topic, for the messages.
        choice: "auto" takes the type of the robot's subscription; "stamped" and "plain" are fixed.
    """

    def __init__(self, topic: str, choice: Choice = "auto") -> None:
        self._topic = topic
        self.type: str | None = _CHOSEN.get(choice)
        """Full name of the command's type; None until it is known."""

    def look(self, types: Iterable[str]) -> str | None:
        """Handle the subscriptions' types; return why the robot would not receive commands."""
        offered = sorted(set(types))
        wanted = [name for name in offered if name in COMMAND_TYPES]
        if not offered:
            return f"{self._topic} has no subscriber; is the robot's bringup running?"
        if len(wanted) != len(offered):
            strange = ", ".join(name for name in offered if name not in COMMAND_TYPES)
            return f"{self._topic} must be TwistStamped or Twist, but {strange} is listened for"
        if len(wanted) > 1:
            return (
                f"both {_short(STAMPED)} and {_short(PLAIN)} are listened for on {self._topic}, "
                "so one of the two would not hear; give all of them the same type "
                "(enable_stamped_cmd_vel of the robot's bringup)"
            )
        if self.type is None:
            self.type = wanted[0]
        if self.type != wanted[0]:
            return (
                f"{self._topic} is subscribed as {_short(wanted[0])}, but {_short(self.type)} is "
                f"sent; reset the robot's enable_stamped_cmd_vel, or restart the servers"
            )
        return None


def _short(type_name: str) -> str:
    return type_name.rpartition("/")[2]
