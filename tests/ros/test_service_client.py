"""Calls of a real service."""

from __future__ import annotations

from typing import Any

import pytest
from std_srvs.srv import SetBool

from bt_mission.core.errors import BtMissionError
from bt_mission.language.message_types import UnknownType
from bt_mission.ros.clients import RosServiceClient
from bt_mission.ros.interface_types import FillError


def serve(node: Any, name: str) -> list[bool]:
    """Answer on a service; gives what was asked."""
    asked: list[bool] = []

    def answer(request: Any, response: Any) -> Any:
        asked.append(request.data)
        response.success = request.data
        response.message = "seen"
        return response

    node.create_service(SetBool, name, answer)
    return asked


def test_an_answer_is_handed_over_once(rig: Any) -> None:
    """When the node's executor serves it, and not within the call."""
    client, server = rig.node("client"), rig.node("server")
    caller = RosServiceClient(client, "ask", "std_srvs/srv/SetBool")
    assert caller.name == "/ask"
    rig.settle()
    assert not caller.is_ready()
    asked = serve(server, "ask")
    rig.settle(caller.is_ready)
    answers: list[Any] = []
    caller.call(caller.prepare({"data": True}), answers.append)
    assert answers == []
    rig.settle(lambda: len(answers) > 0)
    rig.settle()
    assert asked == [True]
    assert [(answer.success, answer.message) for answer in answers] == [(True, "seen")]


def test_a_forgotten_call_is_not_heard_of_any_more(rig: Any) -> None:
    """The server is asked all the same; the next call has its own answer."""
    client, server = rig.node("client"), rig.node("server")
    caller = RosServiceClient(client, "ask", "std_srvs/srv/SetBool")
    asked = serve(server, "ask")
    rig.settle(caller.is_ready)
    late: list[Any] = []
    answers: list[Any] = []
    forget = caller.call(caller.prepare({"data": True}), late.append)
    forget()
    caller.call(caller.prepare({"data": False}), answers.append)
    rig.settle(lambda: len(answers) > 0)
    rig.settle()
    assert asked == [True, False]
    assert late == []
    assert [answer.success for answer in answers] == [False]


def test_a_service_of_another_type_is_refused(rig: Any) -> None:
    """Its answer would never come."""
    serve(rig.node("server"), "ask")
    with pytest.raises(BtMissionError, match="/ask is a std_srvs/srv/SetBool, not a std_srvs/srv/"):
        RosServiceClient(rig.node("client"), "ask", "std_srvs/srv/Trigger")


def test_what_does_not_fit_is_refused_before_the_call(rig: Any) -> None:
    """Values by field, and types by name."""
    node = rig.node("client")
    with pytest.raises(FillError, match="data: expected a boolean"):
        RosServiceClient(node, "ask", "std_srvs/srv/SetBool").prepare({"data": 1})
    with pytest.raises(UnknownType, match="std_srvs/srv/Sat is not installed"):
        RosServiceClient(node, "ask", "std_srvs/srv/Sat")
