"""``bt-mission services call``."""

from __future__ import annotations

import json
from typing import Any

from rclpy.task import Future
from std_srvs.srv import SetBool


def test_the_answer_is_printed(ros: Any, type_in: Any) -> None:
    """As YAML, or as an object."""

    def answer(request: Any, response: Any) -> Any:
        response.success, response.message = request.data, "done\x1b[2J"
        return response

    ros.client.create_service(SetBool, "switch", answer)
    done = type_in("services", "call", "/switch", "data: true")
    assert (done.code, done.out) == (0, 'success: true\nmessage: "done\\e[2J"\n')
    done = type_in("services", "call", "/switch", "--json")
    assert done.code == 1, "no success is no success"
    assert json.loads(done.out)["success"] is False


def test_a_request_that_does_not_fit_is_shown_its_place(ros: Any, type_in: Any) -> None:
    """Nothing is asked."""
    ros.client.create_service(SetBool, "switch", lambda _, response: response)
    done = type_in("services", "call", "/switch", "data: 3")
    assert done.code == 2
    assert "request:1:7: error: expected a boolean (bool), got the number 3" in done.err


def test_a_service_that_is_not_there_exits_with_5(ros: Any, type_in: Any) -> None:
    """With what there is."""
    ros.client.create_service(SetBool, "switch", lambda _, response: response)
    done = type_in("services", "call", "/swich", "--wait", "1")
    assert done.code == 5
    assert "no service /swich in the graph (looked for 1 s)" in done.err
    assert "did you mean '/switch'?" in done.err
    done = type_in("services", "call", "/x", "--type", "std_srvs/srv/SetBool", "--wait", "1")
    assert (done.code, done.err) == (5, "no server of /x after 1 s [BT-901]\n")


def test_a_server_that_does_not_answer_exits_with_6(ros: Any, type_in: Any) -> None:
    """After --timeout."""

    async def never(_: Any, response: Any) -> Any:
        await Future()
        return response

    ros.node("silent").create_service(SetBool, "switch", never)
    done = type_in("services", "call", "/switch", "--timeout", "1")
    assert (done.code, done.err) == (6, "/switch did not answer within 1 s\n")
