"""Taps decide what becomes of whatever passes between nodes, at exact virtual times."""

from __future__ import annotations

from typing import Any

import pytest
from action_msgs.msg import GoalStatus
from bt_mission_interfaces.action import Turn
from rclpy.action import ActionClient, ActionServer
from rclpy.serialization import deserialize_message
from std_msgs.msg import Int32
from std_srvs.srv import SetBool

from bt_mission.base.errors import BtMissionError
from bt_mission.ros.virtual_time import Delivery, Gate, Passing, ServiceResponse, Side
from bt_mission.sessions.scripted_server import ScriptedServer

S = 1_000_000_000


@pytest.fixture
def numbers(rig: Any) -> Any:
    """One node says 0, 1, 2, ... once a second from 2 s on; two hear it, and note when."""
    rig.received = {"a": [], "b": []}
    sender = rig.node("sender")
    publisher = sender.create_publisher(Int32, "numbers", 10)
    count = iter(range(1000))
    sender.create_timer(1.0, lambda: publisher.publish(Int32(data=next(count))))
    for name, received in rig.received.items():
        node = rig.node(name)

        def hear(message: Int32, node: Any = node, messages: list[Any] = received) -> None:
            messages.append((rig.now(node) / S, message.data))

        node.create_subscription(Int32, "numbers", hear, 10)
    return rig


def test_without_a_tap_everything_arrives_at_once(numbers: Any) -> None:
    """The state that taps change."""
    numbers.steps_until(4 * S)
    assert numbers.received == {"a": [(2, 0), (3, 1), (4, 2)], "b": [(2, 0), (3, 1), (4, 2)]}


def test_a_tap_drops_delays_repeats_and_changes_for_one_receiver(numbers: Any) -> None:
    """Delays end at their own instant, also between two timers; nobody else notices."""

    def tap(passing: Passing) -> list[Delivery | ServiceResponse]:
        if passing.receiver != "/a":
            return [Delivery(passing.message)]
        fates: dict[int, list[Delivery | ServiceResponse]] = {
            0: [],
            1: [Delivery(passing.message, after_ns=1_250_000_000)],
            2: [Delivery(passing.message), Delivery(passing.message)],
            3: [Delivery(Int32(data=99))],
        }
        return fates[passing.message.data]

    numbers.clock.taps.add("/numbers", Side.MESSAGE, tap)
    numbers.steps_until(5 * S)
    assert numbers.received["a"] == [(4, 2), (4, 2), (4.25, 1), (5, 99)]
    assert numbers.received["b"] == [(2, 0), (3, 1), (4, 2), (5, 3)]


def test_taps_of_one_name_follow_each_other(numbers: Any) -> None:
    """The second sees what the first lets through, when it does; one can be taken away again."""
    seen = []

    def late(passing: Passing) -> list[Delivery]:
        return [Delivery(passing.message, after_ns=S // 2)]

    def plus_ten(passing: Passing) -> list[Delivery]:
        seen.append(passing.time_ns / S)
        return [Delivery(Int32(data=passing.message.data + 10))]

    remove = numbers.clock.taps.add("/numbers", Side.MESSAGE, late)
    numbers.clock.taps.add("/numbers", Side.MESSAGE, plus_ten)
    numbers.steps_until(2 * S)
    remove()
    remove()
    numbers.steps_until(3 * S)
    assert numbers.received["a"] == [(2.5, 10), (3, 11)]
    assert seen == [2.5, 2.5, 3, 3]


def test_what_is_delayed_beyond_the_life_of_its_receiver_is_lost(numbers: Any) -> None:
    """A callback of a node that was destroyed is not called."""
    numbers.clock.taps.add(
        "/numbers", Side.MESSAGE, lambda p: [Delivery(p.message, after_ns=3 * S // 2)]
    )
    numbers.steps_until(2 * S)
    node = numbers.nodes[1]
    numbers.clock.remove_node(node)
    numbers.steps_until(4 * S)
    assert numbers.received == {"a": [], "b": [(3.5, 0)]}


def test_raw_subscriptions_are_tapped_too(numbers: Any) -> None:
    """What they get is bytes again."""
    raw: list[int] = []
    numbers.nodes[1].create_subscription(
        Int32, "numbers", lambda b: raw.append(deserialize_message(b, Int32).data), 10, raw=True
    )

    def tap(passing: Passing) -> list[Delivery]:
        data = passing.message.data
        return [] if data == 0 else [Delivery(Int32(data=10 * data))]

    numbers.clock.taps.add("/numbers", Side.MESSAGE, tap)
    numbers.steps_until(4 * S)
    assert raw == [10, 20]
    assert numbers.received["a"] == [(3, 10), (4, 20)]


def test_a_gate_holds_back_until_it_is_opened(numbers: Any) -> None:
    """For as long as that takes; the taps behind it see what passes then."""
    gate = Gate()
    seen: list[float] = []

    def behind(passing: Passing) -> list[Delivery]:
        seen.append(passing.time_ns / S)
        return [Delivery(passing.message)]

    numbers.clock.taps.add("/numbers", Side.MESSAGE, lambda p: [Delivery(p.message, gate=gate)])
    numbers.clock.taps.add("/numbers", Side.MESSAGE, behind)
    numbers.clock.call_at(7 * S // 2, lambda: gate.open(15 * S // 4))
    numbers.clock.call_at(4 * S, lambda: gate.open(9 * S))
    numbers.steps_until(4 * S)
    assert numbers.received["a"] == [(3.75, 0), (3.75, 1), (4, 2)]
    assert seen == [3.75] * 4 + [4] * 2


def test_a_service_is_tapped_in_both_directions(rig: Any) -> None:
    """A request is held back or answered in the server's place, a response changed."""
    served: list[bool] = []

    def serve(request: Any, response: Any) -> Any:
        served.append(request.data)
        response.message = "from the server"
        return response

    rig.node("server").create_service(SetBool, "switch", serve)
    node = rig.node("client")
    node.create_timer(1.0, lambda: None)
    client = node.create_client(SetBool, "switch")

    def on_request(passing: Passing) -> list[Delivery | ServiceResponse]:
        if passing.message.data:
            return [ServiceResponse(SetBool.Response(message="from the tap"), after_ns=S // 4)]
        return [Delivery(passing.message, after_ns=S // 2)]

    def on_response(passing: Passing) -> list[Delivery]:
        passing.message.success = True
        return [Delivery(passing.message)] * 2  # the second finds nobody waiting

    rig.clock.taps.add("/switch", Side.REQUEST, on_request)
    rig.clock.taps.add("/switch", Side.RESPONSE, on_response)
    answered = client.call_async(SetBool.Request(data=True))
    held = client.call_async(SetBool.Request(data=False))
    times: list[float] = []
    for future in (answered, held):
        future.add_done_callback(lambda _: times.append(rig.clock.now_ns / S))
    rig.clock.run_until_quiet()
    rig.steps_until(4 * S)
    assert (answered.result().message, answered.result().success) == ("from the tap", True)
    assert (held.result().message, held.result().success) == ("from the server", True)
    assert served == [False]
    assert times == [1.25, 1.5]


def test_a_response_cannot_be_answered(rig: Any) -> None:
    """That is a mistake of the tap's author."""
    rig.node("server").create_service(SetBool, "switch", lambda _, response: response)
    client = rig.node("client").create_client(SetBool, "switch")
    rig.clock.taps.add("/switch", Side.RESPONSE, lambda p: [ServiceResponse(p.message)])
    client.call_async(SetBool.Request())
    with pytest.raises(TypeError, match="a response of /switch cannot be answered"):
        rig.clock.run_until_quiet()


@pytest.mark.parametrize("part", ["goal", "cancel", "result"])
def test_each_service_of_an_action_is_tapped(rig: Any, part: str) -> None:
    """At rclpy's own client; the response comes a second late."""
    server = ScriptedServer(rig.node("server"), "bt_mission_interfaces/action/Turn", "turn")
    node = rig.node("client")
    node.create_timer(0.25, lambda: None)
    client = ActionClient(node, Turn, "turn")
    name = {"goal": "send_goal", "cancel": "cancel_goal", "result": "get_result"}[part]
    rig.clock.taps.add(
        f"/turn/_action/{name}", Side.RESPONSE, lambda p: [Delivery(p.message, after_ns=S)]
    )
    times: dict[str, float] = {}

    def pass_until_done(what: str, future: Any) -> Any:
        rig.clock.run_until_quiet()
        begin_ns = rig.clock.now_ns
        while not future.done():
            rig.clock.step()
        times[what] = (rig.clock.now_ns - begin_ns) / S
        return future.result()

    handle = pass_until_done("goal", client.send_goal_async(Turn.Goal(angle=9.0)))
    pass_until_done("cancel", handle.cancel_goal_async())
    result = pass_until_done("result", handle.get_result_async())
    assert (server.goal.cancels, result.status) == (1, GoalStatus.STATUS_CANCELED)
    assert times == {"goal": 0, "cancel": 0, "result": 0} | {part: 1}


def test_feedback_of_an_action_is_tapped(rig: Any) -> None:
    """Lost, and of another goal: rclpy tells the goal's own callback."""
    server = ScriptedServer(rig.node("server"), "bt_mission_interfaces/action/Turn", "turn")
    client = ActionClient(rig.node("client"), Turn, "turn")
    messages: list[float] = []
    sent = client.send_goal_async(
        Turn.Goal(angle=9.0), feedback_callback=lambda m: messages.append(m.feedback.current_angle)
    )
    rig.clock.run_until_quiet()
    assert sent.done()
    rig.clock.taps.add(
        "/turn/_action/feedback",
        Side.MESSAGE,
        lambda p: [Delivery(p.message)] if p.message.feedback.current_angle > 1 else [],
    )
    for angle in (1.0, 2.0):
        server.goal.feed(current_angle=angle)
        rig.clock.run_until_quiet()
    assert messages == [2.0]


def own_server(rig: Any, node: Any, *names: str) -> Any:
    """An action server of rclpy's own for each name."""
    return [
        ActionServer(node, Turn, name, lambda handle: (handle.succeed(), Turn.Result())[1])
        for name in names
    ]


@pytest.mark.parametrize("whose", ["ours", "rclpy's"])
def test_an_action_server_is_answered_for(rig: Any, whose: str) -> None:
    """Rclpy's own does not keep its name, which is known from its node and type."""
    for served_by, name in (("server", "turn"), ("other", "other_turn")):
        if whose == "rclpy's":
            own_server(rig, rig.node(served_by), name)
        else:
            ScriptedServer(rig.node(served_by), "bt_mission_interfaces/action/Turn", name)
    node = rig.node("client")
    node.create_timer(0.25, lambda: None)
    client = ActionClient(node, Turn, "turn")
    rig.clock.taps.add(
        "/turn/_action/send_goal",
        Side.REQUEST,
        lambda p: (
            [Delivery(p.message, after_ns=S)]
            if p.message.goal.angle > 5
            else [ServiceResponse(Turn.Impl.SendGoalService.Response(accepted=False))]
        ),
    )
    rejected, late = (client.send_goal_async(Turn.Goal(angle=angle)) for angle in (1.0, 9.0))
    rig.clock.run_until_quiet()
    assert (rejected.result().accepted, late.done()) == (False, False)
    begin_ns = rig.clock.now_ns
    while not late.done():
        rig.clock.step()
    assert (late.result().accepted, rig.clock.now_ns - begin_ns) == (True, S)


def test_actions_of_one_type_on_one_node_cannot_be_tapped(rig: Any) -> None:
    """Which one a request is for is not known; without taps they work."""
    own_server(rig, rig.node("server"), "turn", "turn_back")
    client = ActionClient(rig.node("client"), Turn, "turn")
    rig.clock.taps.add("/scan", Side.MESSAGE, lambda _: [])
    client.send_goal_async(Turn.Goal())
    rig.clock.run_until_quiet()
    rig.clock.taps.add("/turn_back/_action/send_goal", Side.REQUEST, lambda _: [])
    client.send_goal_async(Turn.Goal())
    with pytest.raises(BtMissionError, match="/turn and /turn_back have one type and one node"):
        rig.clock.run_until_quiet()
