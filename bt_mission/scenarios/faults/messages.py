"""Faults of messages on their way: topics, goals and their results, feedback.

They are the same for our servers, for those that a test plays, and for any other: what passes
between nodes is caught.
"""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from dataclasses import replace
from functools import partial
from typing import Any

from action_msgs.srv import CancelGoal
from rclpy.serialization import deserialize_message, serialize_message
from unique_identifier_msgs.msg import UUID

from bt_mission.executive.events.events import Event, GoalChanged
from bt_mission.ros.clients import DEPTH
from bt_mission.ros.interface_types import topic_type
from bt_mission.ros.virtual_time import Delivery, Gate, Passing, ServiceResponse, Side
from bt_mission.ros.virtual_time.discovery import wait_for_matching
from bt_mission.scenarios.draws import Draws, maybe, one_of
from bt_mission.scenarios.faults.corruptions import (
    READY_MADE,
    changed_by,
    corruptions_of,
    restamp,
    setting,
)
from bt_mission.scenarios.faults.drawable import Drawable
from bt_mission.scenarios.faults.effects import (
    FEEDBACK,
    PARTS,
    MakeTap,
    action,
    late,
    lose,
    nanoseconds,
    on,
    passed,
    receiver_of,
    repeat,
    topic,
)
from bt_mission.scenarios.faults.fault import Fates, FaultInstance, Tap
from bt_mission.scenarios.faults.kind import Arguments, Effect, FaultKind
from bt_mission.scenarios.faults.parameters import (
    ABOVE_0,
    ACTION,
    FROM_1,
    FROM_2,
    GOALS,
    RECEIVER,
    SHARE,
    TOPIC,
    Parameter,
    any_of,
    period,
    seconds,
    steps,
    whole,
)

ASKED = action(("goal", Side.REQUEST))
ANSWERED = action(("goal", Side.RESPONSE))
CANCELS = action(("cancel", Side.REQUEST))
RESULTS = action(("result", Side.RESPONSE))
ALL_OF_ACTION = action(
    *((part, side) for part in PARTS for side in (Side.REQUEST, Side.RESPONSE)),
    ("feedback", Side.MESSAGE),
)


# ---- effects -----------------------------------------------------------------------------------


def _drop(fault: FaultInstance, given: Arguments) -> Tap:
    every = given["every"]
    if every is None:
        return lose(fault, given)

    def drop_every(fault: FaultInstance, passing: Passing) -> Fates:
        count = fault.kept[passing.receiver] = fault.kept.get(passing.receiver, -1) + 1
        return passed(fault, passing) if count % every else ()

    return drop_every


def _delay(fault: FaultInstance, given: Arguments) -> None:
    """Delay messages, so that none overtakes what is under way when the fault has ended."""
    by_ns, jitter_ns = nanoseconds(given["by"]), nanoseconds(given["jitter"])
    name, receiver = fault.topic(given["topic"]), receiver_of(fault, given)
    last: dict[str, int] = {}

    def tap(passing: Passing) -> Fates:
        if receiver not in (None, passing.receiver):
            return passed(fault, passing)
        after_ns = 0
        if fault.ended_ns is None:
            after_ns = by_ns
            if jitter_ns:
                after_ns += fault.draw(passing).randrange(jitter_ns + 1)
        if given["in_order"]:
            due_ns = max(passing.time_ns + after_ns, last.get(passing.receiver, 0))
            last[passing.receiver] = due_ns
            after_ns = due_ns - passing.time_ns
        return (Delivery(passing.message, after_ns=after_ns),)

    fault.run.stage.clock.taps.add(name, Side.MESSAGE, tap)  # it stays after the end
    fault.undo(lambda: None)


def _publish(fault: FaultInstance, given: Arguments) -> None:
    """Publish a message, once or in intervals, and lose the messages of other publishers."""
    name, clock = fault.topic(given["topic"]), fault.run.stage.clock
    message = _with_type(fault, name)()
    setting(fault.fault.what, given["fields"])(message)
    node = fault.run.robot_run.node
    publisher = node.create_publisher(type(message), name, DEPTH)
    fault.undo(lambda: node.destroy_publisher(publisher))
    wait_for_matching(tuple(clock.get_nodes()))
    # What is received is rounded to float32, and NaN is not equal to NaN.
    sent = repr(deserialize_message(serialize_message(message), type(message)))

    def tap(fault: FaultInstance, passing: Passing) -> Fates:
        return passed(fault, passing) if repr(passing.message) == sent else ()

    def send() -> None:
        if fault.ended_ns is None:
            publisher.publish(message)
            if given["every"] is not None:
                clock.call_at(clock.now_ns + nanoseconds(given["every"]), send)

    fault.tap(name, Side.MESSAGE, tap)
    send()


def _subscribe(fault: FaultInstance, given: Arguments) -> None:
    name, node = fault.topic(given["topic"]), fault.run.robot_run.node
    kind = _with_type(fault, name)
    for _ in range(given["times"]):
        subscription = node.create_subscription(kind, name, lambda _: None, DEPTH)
        fault.undo(partial(node.destroy_subscription, subscription))
    wait_for_matching(tuple(fault.run.stage.clock.get_nodes()))


def _with_type(fault: FaultInstance, name: str) -> Any:
    """Return the class of the messages of a topic of the graph."""
    return topic_type(dict(fault.run.robot_run.node.get_topic_names_and_types())[name][0])


def _freeze(_: FaultInstance, given: Arguments) -> Tap:
    def freeze(fault: FaultInstance, passing: Passing) -> Fates:
        again = deepcopy(fault.kept.setdefault(passing.receiver, passing.message))
        if given["fresh_stamps"]:
            restamp(again, passing.message)
        return (Delivery(again),)

    return freeze


def _freeze_feedback(_: FaultInstance, _given: Arguments) -> Tap:
    def freeze(fault: FaultInstance, passing: Passing) -> Fates:
        goal = bytes(passing.message.goal_id.uuid)
        return (Delivery(deepcopy(fault.kept.setdefault(goal, passing.message))),)

    return freeze


def _changing(change: Callable[[Any], Any], part: str = "") -> Tap:
    """Return what changes messages, or a part of each."""

    def tap(_: FaultInstance, passing: Passing) -> Fates:
        message = passing.message
        if not part:
            return (Delivery(change(message)),)
        setattr(message, part, change(getattr(message, part)))
        return (Delivery(message),)

    return tap


def _corrupt(part: str = "") -> MakeTap:
    return lambda _, given: _changing(changed_by(given["how"], given["field"]), part)


def _forge(_: FaultInstance, given: Arguments) -> Tap:
    """Send feedback of the goal before, or where there is none, of one that nobody has sent."""
    corrupt = changed_by("nan", None)

    def forge(fault: FaultInstance, passing: Passing) -> Fates:
        goal = bytes(passing.message.goal_id.uuid)
        known = list(fault.kept) or [fault.generator().randbytes(16)]
        other = fault.kept.setdefault(goal, known[-1])
        forged = deepcopy(passing.message)
        forged.goal_id = UUID(uuid=list(other))
        forged.feedback = corrupt(forged.feedback)
        own = () if given["instead"] else (Delivery(passing.message),)
        return (Delivery(forged), *own)

    return forge


def _set_fields(fault: FaultInstance, given: Arguments) -> Tap:
    change = setting(fault.fault.what, given["fields"])
    change(_with_type(fault, fault.topic(given["topic"]))())  # refuses unknown fields
    return _changing(change)


def _set_part(part: str) -> MakeTap:
    """Return what sets fields of the feedback or of the result of an action."""

    def make(fault: FaultInstance, given: Arguments) -> Tap:
        change = setting(fault.fault.what, given["fields"])
        change(getattr(fault.action_type(given["action"]), part.capitalize())())
        return _changing(change, part)

    return make


def _reject(fault: FaultInstance, given: Arguments) -> Tap:
    response = fault.action_type(given["action"]).Impl.SendGoalService.Response
    return lambda *_: (ServiceResponse(response(accepted=False)),)


def _refuse(_: FaultInstance, _given: Arguments) -> Tap:
    refusal = ServiceResponse(CancelGoal.Response(return_code=CancelGoal.Response.ERROR_REJECTED))
    return lambda *_: (refusal,)


def _answer_after_halt(fault: FaultInstance, given: Arguments) -> None:
    """Hold goal responses until the client no longer wants the goal."""
    name, clock, gates = fault.action(given["action"]), fault.run.stage.clock, []

    def hold(_: FaultInstance, passing: Passing) -> Fates:
        gates.append(gate := Gate())
        if given["at_most"] is not None:
            gate.open(passing.time_ns + nanoseconds(given["at_most"]))
        return (Delivery(passing.message, gate=gate),)

    def release(by_ns: int) -> None:
        for gate in gates:
            gate.open(clock.now_ns + by_ns)

    def take(event: Event) -> None:
        match event:
            case GoalChanged(action=action, change="released") if action == name:
                release(nanoseconds(given["after"]))

    events = fault.run.robot_run.executive.events
    events.subscribe(take)
    fault.undo(lambda: events.unsubscribe(take))
    fault.undo(lambda: release(0))
    on(ANSWERED, lambda *_: hold)(fault, given)


def _repeat_answers(fault: FaultInstance, given: Arguments) -> None:
    on(action((given["part"], Side.RESPONSE)), repeat)(fault, given)


# ---- checks and draws --------------------------------------------------------------------------


def _share_or_every(given: Arguments) -> str:
    has_both = given["every"] is not None and given["share"] != 1
    return "give 'share' or 'every', not both" if has_both else ""


def _no_field_of_function(given: Arguments) -> str:
    is_function = callable(given["how"]) and given["field"] is not None
    return "'field' needs a named corruption, not a function" if is_function else ""


def _drawn_freeze(draws: Draws, drawable: Drawable) -> Arguments:
    name = one_of(draws, tuple(drawable.topics))
    has_stamps = "old stamp" in corruptions_of(drawable.topics[name])
    return {"topic": name, **({"fresh_stamps": True} if has_stamps and maybe(draws, 4) else {})}


def _drawn_corruption(draws: Draws, drawable: Drawable) -> Arguments:
    ways = {name: corruptions_of(kind) for name, kind in drawable.topics.items()}
    name = one_of(draws, [name for name, each in ways.items() if each])
    return {"topic": name, "how": one_of(draws, ways[name])}


def _drawn_field(fault: str, target: str) -> Callable[[Draws, Drawable], Arguments]:
    def draw(draws: Draws, drawable: Drawable) -> Arguments:
        chosen = one_of(draws, drawable.fields_of(fault))
        return {target: chosen.target, chosen.field: one_of(draws, chosen.values)}

    return draw


# ---- rows --------------------------------------------------------------------------------------


def _topic(
    name: str, text: str, effect: Effect, *own: Parameter, group: str, **options: Any
) -> FaultKind:
    return FaultKind(name, text, effect, (TOPIC, *own), "Topics", group, **options)


def _action(
    name: str, text: str, effect: Effect, *own: Parameter, group: str = "servers", **options: Any
) -> FaultKind:
    return FaultKind(name, text, effect, (ACTION, *own), "Action servers", group, **options)


LATE = seconds("by", drawn=period(0.1, 1.5, 0.1))
AFTER = seconds("after", "From each to the next.", default=0.0, by_name=True)
TIMES = Parameter("times", "integer", "How often.", 2, allowed=FROM_2, by_name=True)
FIRST = replace(GOALS, drawn=whole(1, 3))
REQUESTS = replace(FIRST, name="times")
FIELD = Parameter(
    "field", "text", "Only this field, by its dotted name.", default=None, by_name=True
)
HOW = Parameter(
    "how",
    "text",
    "Old and future stamps are 10 s off. In Python also a function.",
    choices=tuple(READY_MADE),
    takes=Callable,
)

ROWS = (
    _topic(
        "drop",
        "Messages are lost: all, a share, or every Nth.",
        on(topic, _drop),
        replace(SHARE, drawn=steps(0.25, 1, 0.25)),
        Parameter(
            "every",
            "integer",
            "Instead of a share, from the first message on.",
            default=None,
            allowed=FROM_1,
            by_name=True,
        ),
        RECEIVER,
        group="network",
        check=_share_or_every,
    ),
    _topic(
        "publish",
        "A message with these fields is published. Messages of other publishers are lost.",
        _publish,
        seconds(
            "every",
            "Published again after each interval; default: once.",
            default=None,
            allowed=ABOVE_0,
            by_name=True,
        ),
        group="scripts",
        takes_fields=True,
    ),
    _topic(
        "subscribe",
        "The topic has more subscriptions.",
        _subscribe,
        replace(TIMES, text="How many.", default=1, allowed=FROM_1),
        group="scripts",
    ),
    _topic(
        "delay",
        "Messages are late. Those under way at the end still arrive.",
        _delay,
        seconds("by", drawn=period(0.05, 0.5, 0.05)),
        seconds(
            "jitter",
            "Up to this much more, drawn for each message.",
            default=0.0,
            by_name=True,
            drawn=steps(0, 0.1, 0.05),
        ),
        Parameter(
            "in_order",
            "flag",
            "Whether messages keep their order (the default).",
            default=True,
            by_name=True,
            is_quiet=True,
        ),
        RECEIVER,
        group="network",
    ),
    _topic(
        "duplicate",
        "Messages arrive more than once.",
        on(topic, repeat),
        TIMES,
        AFTER,
        SHARE,
        RECEIVER,
        group="network",
    ),
    _topic(
        "freeze",
        "The first message is repeated instead of all after it.",
        on(topic, _freeze),
        Parameter(
            "fresh_stamps",
            "flag",
            "With the stamps of the replaced messages, as of a sensor that hangs.",
            default=False,
            by_name=True,
        ),
        RECEIVER,
        group="messages",
        draw=_drawn_freeze,
    ),
    _topic(
        "corrupt",
        "Messages have wrong values.",
        on(topic, _corrupt()),
        HOW,
        FIELD,
        SHARE,
        RECEIVER,
        group="messages",
        check=_no_field_of_function,
        draw=_drawn_corruption,
    ),
    _action("reject_goals", "The next goals are rejected.", on(ASKED, _reject), FIRST),
    _action("ignore_goals", "Goals never reach the server.", on(ASKED, lose), FIRST),
    _action(
        "drop_answers",
        "The server executes goals, but its goal responses are lost.",
        on(ANSWERED, lose),
        FIRST,
    ),
    _action(
        "delay_answers",
        "Goal responses are late; the server already executes the goals.",
        on(ANSWERED, late),
        LATE,
        GOALS,
        group="network",
    ),
    _action("drop_results", "Results are lost.", on(RESULTS, lose), FIRST),
    _action("delay_results", "Results are late.", on(RESULTS, late), LATE, GOALS, group="network"),
    _action(
        "answer_after_halt",
        "The goal response arrives after the client has abandoned the goal.",
        _answer_after_halt,
        seconds("after", "From the abandonment to the response.", default=0.0, by_name=True),
        seconds("at_most", "The latest time of the response.", default=None, by_name=True),
    ),
    _action(
        "repeat_answers",
        "The server responds more than once: to the goal, to a cancel, or with the result.",
        _repeat_answers,
        Parameter(
            "part", "text", default="goal", choices=PARTS, drawn=any_of("goal", "result", "cancel")
        ),
        TIMES,
        replace(AFTER, drawn=steps(0, 0.5, 0.1)),
    ),
    _action(
        "refuse_cancels", "Cancel requests are rejected.", on(CANCELS, _refuse, "times"), REQUESTS
    ),
    _action("ignore_cancels", "Cancel requests are lost.", on(CANCELS, lose, "times"), REQUESTS),
    _action(
        "delay_feedback",
        "Feedback is late, also after the end of the goal.",
        on(FEEDBACK, late),
        LATE,
        group="network",
    ),
    _action(
        "slow_server",
        "Each request, response and feedback message takes this time.",
        on(ALL_OF_ACTION, late),
        LATE,
        group="network",
    ),
    _action("silence_feedback", "No feedback arrives.", on(FEEDBACK, lose), group="network"),
    _action(
        "corrupt_feedback",
        "Feedback has wrong values.",
        on(FEEDBACK, _corrupt("feedback")),
        replace(HOW, default="nan", drawn=any_of("nan", "zeros")),
        FIELD,
        group="messages",
        check=_no_field_of_function,
    ),
    _action(
        "freeze_feedback",
        "The first feedback of each goal is repeated.",
        on(FEEDBACK, _freeze_feedback),
        group="messages",
    ),
    _action(
        "forge_feedback",
        "Feedback of another goal, with NaN, arrives as well.",
        on(FEEDBACK, _forge),
        Parameter("instead", "flag", "In place of the right one.", False, by_name=True),
        group="messages",
    ),
    _topic(
        "set_fields",
        "These fields have other values. Names may be dotted; values fit the type.",
        on(topic, _set_fields),
        group="messages",
        takes_fields=True,
        needs_fields=True,
        draw=_drawn_field("set_fields", "topic"),
    ),
    _action(
        "set_feedback",
        "These fields of the feedback have other values.",
        on(FEEDBACK, _set_part("feedback")),
        group="messages",
        takes_fields=True,
        needs_fields=True,
        draw=_drawn_field("set_feedback", "action"),
    ),
    _action(
        "set_result",
        "These fields of results have other values; the status of the goal stays.",
        on(RESULTS, _set_part("result")),
        group="messages",
        takes_fields=True,
        needs_fields=True,
        draw=_drawn_field("set_result", "action"),
    ),
)
