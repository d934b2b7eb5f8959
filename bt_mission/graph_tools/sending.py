"""Sends one goal and steps until it has ended; the first Ctrl-C cancels it, the second leaves."""

from __future__ import annotations

import secrets
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TextIO

from rich.console import Console

from bt_mission.graph_tools.goal_lines import GoalLines, GoalObjects
from bt_mission.graph_tools.goal_picture import GoalPicture
from bt_mission.graph_tools.goal_request import GoalListener, GoalRequest, GoalResult
from bt_mission.graph_tools.rosout_listener import RosoutListener
from bt_mission.ros.goal_client import RosGoalClient

if TYPE_CHECKING:
    from bt_mission.graph_tools.graph_session import GraphSession
    from bt_mission.graph_tools.interface_description import InterfaceDescription


def audience_for(
    stream: TextIO, about: InterfaceDescription, goal: Any, *, json: bool, plain: bool
) -> GoalListener:
    """A picture on a terminal, lines in a pipe, objects for programs."""
    if json:
        return GoalObjects(stream)
    console = Console(file=stream, highlight=False)
    if plain or not console.is_terminal or console.is_dumb_terminal:
        return GoalLines(stream, about)
    return GoalPicture(console, about, goal)


class Sender:
    """Sends goals of one action.

    :param hand: its node owns the client.
    :param action: the action's full name.
    :param type_name: of the action.
    :raises BtMissionError: when the type is not installed, or the action has another one.
    """

    def __init__(self, hand: GraphSession, action: str, type_name: str) -> None:
        self._hand = hand
        self._rejections = RosoutListener(hand.node, action)
        self._courier = RosGoalClient(hand.node, action, type_name, lambda _: "")

    def prepare(self, fields: Mapping[str, Any]) -> Any:
        """A goal message with these fields. Raises BtMissionError."""
        return self._courier.prepare(fields)

    def open(
        self, request: Any, audience: GoalListener, *, server_s: float, limit_s: float | None = None
    ) -> GoalRequest:
        """A goal that :meth:`GoalRequest.poll` sends and sees to its end."""
        return GoalRequest(
            self._courier,
            request,
            audience,
            secrets.token_hex(8),
            self._hand.now_ns,
            server_s=server_s,
            limit_s=limit_s,
            why_rejected=self._rejections.why,
        )


def see_through(hand: GraphSession, goal: GoalRequest) -> GoalResult:
    """Step until the goal has ended.

    The first Ctrl-C, and a reader of our output that leaves, cancel the goal and wait for its end;
    a second Ctrl-C leaves at once.
    """
    while True:
        try:
            if (end := goal.poll(hand.now_ns)) is not None:
                return end
            if hand.interrupts == 1:
                goal.cancel(f"interrupted by {hand.interrupted_by}", hand.now_ns)
            elif hand.interrupts > 1:
                goal.leave(f"left at once after a second {hand.interrupted_by}", hand.now_ns)
        except BrokenPipeError:
            goal.mute()
            goal.cancel("nobody reads the output any more", hand.now_ns)
        hand.step()
