"""Calls a service once."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from bt_mission.core.errors import BtMissionError, NotThereError
from bt_mission.graph_tools.graph_session import wait
from bt_mission.graph_tools.interface_description import describe_interface
from bt_mission.graph_tools.yaml_text import read_fields
from bt_mission.ros.service_client import RosServiceClient

if TYPE_CHECKING:
    from bt_mission.graph_tools.graph_session import GraphSession


class Silence(BtMissionError):  # noqa: N818 - what it is says more than that it is an error
    """A server that does not answer."""


def ask(
    hand: GraphSession, name: str, type_name: str, text: str, *, server_s: float, answer_s: float
) -> Any:
    """Call a service with a request in YAML; gives the response.

    :raises BtMissionError: when the request does not fit the type, or the type is not installed.
    :raises NotThereError: when there is no server.
    :raises Silence: when it does not answer in time.
    :raises KeyboardInterrupt: when Ctrl-C came.
    """
    caller = RosServiceClient(hand.node, name, type_name)
    fields = read_fields(text, describe_interface(type_name).part("request").shape, "request")
    request = caller.prepare(fields)
    if not wait(hand, server_s, caller.is_ready):
        raise NotThereError(f"no server of {name} after {server_s:g} s")
    answers: list[Any] = []
    forget = caller.call(request, answers.append)
    if not wait(hand, answer_s, lambda: bool(answers)):
        forget()
        raise Silence(f"{name} did not answer within {answer_s:g} s")
    return answers[0]
