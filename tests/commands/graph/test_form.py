"""The form for a goal, driven by Textual's own pilot over a graph on the virtual clock."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from typing import Any

import pytest
from std_srvs.srv import SetBool
from textual.pilot import Pilot
from textual.widgets import Checkbox, Input, Static

from bt_mission.base.errors import BtMissionError
from bt_mission.commands.graph.form import FormLine, GoalFormApp
from bt_mission.commands.graph.goal_events import GoalOutcome
from bt_mission.commands.graph.goal_request import GoalSender
from bt_mission.commands.graph.interface_description import InterfaceDescription, InterfacePart
from bt_mission.language.interface_comments import Section
from tests.support.graph import TURN

Script = Callable[[GoalFormApp, Pilot[Any]], Awaitable[None]]


@pytest.fixture
def fill_in(hand: Any) -> Callable[..., GoalFormApp]:
    """Open a form for /turn and act: ``fill_in(script)`` gives the form when it has closed."""

    def run(
        script: Script, type_name: str = TURN, encoding: str = "utf-8", **fields: Any
    ) -> GoalFormApp:
        form = GoalFormApp(
            hand,
            GoalSender(hand, "/turn", type_name, server_s=5.0),
            fields,
            encoding=encoding,
            period_s=None,  # the script serves
        )

        async def act() -> None:
            async with form.run_test(size=(80, 24)) as pilot:
                await script(form, pilot)

        asyncio.run(act())
        return form

    return run


def shown(form: GoalFormApp, name: str) -> str:
    """The text of a part of the form."""
    return str(form.query_one(name, Static).render())


def note(form: GoalFormApp, index: int) -> str:
    """What stands below a field."""
    return str(list(form.query(FormLine))[index].query_one(".note", Static).render())


async def until(form: GoalFormApp, pilot: Pilot[Any], done: Callable[[], Any]) -> None:
    """Let virtual time pass until something holds."""
    for _ in range(1000):
        if done():
            await pilot.pause()
            return
        form.serve()
    raise AssertionError("it never came")


def test_a_goal_is_typed_and_sent(ros: Any, fill_in: Any) -> None:
    """Field by field with Enter; from the last one it is sent. Feedback has bars."""
    server = ros.server()

    async def script(form: GoalFormApp, pilot: Pilot[Any]) -> None:
        await pilot.press(*"90", "enter", *"0.5", "enter")
        await until(form, pilot, lambda: server.goals)
        server.goal.feed(current_angle=45.0, remaining_angle=45.0)
        await until(form, pilot, lambda: "current_angle" in _page(form))
        assert "current_angle" in _page(form)
        assert "██████████░░░░░░░░░░ of 90" in _page(form)
        server.goal.succeed(angle_turned=90.0)
        await until(form, pilot, lambda: shown(form, "#state").startswith("succeeded after"))
        assert "angle_turned  90 deg" in _page(form)
        await pilot.press("ctrl+q")

    form = fill_in(script)
    assert (server.goal.request.angle, server.goal.request.angular_velocity) == (90.0, 0.5)
    assert form.return_value.how is GoalOutcome.SUCCEEDED
    assert form.last_words[1:] == [
        "  angle_turned  90 deg",
        "  error_code    0  (NONE)",
        "  error_msg     ''",
    ]


def _page(form: GoalFormApp) -> str:
    """All that stands on the screen."""
    return "\n".join(strip.text for strip in form.screen._compositor.render_strips())


def test_a_field_says_what_is_wrong_while_it_is_typed(ros: Any, fill_in: Any) -> None:
    """And nothing is sent until it is right."""
    server = ros.server()

    async def script(form: GoalFormApp, pilot: Pilot[Any]) -> None:
        assert note(form, 0).startswith("how far to turn; left (anticlockwise) is positive")
        await pilot.press(*"9x")
        assert note(form, 0) == "expected a number (float32), got string '9x'"
        await pilot.press("tab", *"[1")
        assert note(form, 1).startswith("this '[' has no closing")
        await pilot.press("ctrl+s")
        assert shown(form, "#state") == "not sent: angle, angular_velocity invalid"
        assert form.focused is form.query(Input).first()
        await pilot.press("end", "backspace", "tab", "ctrl+u")
        assert note(form, 1).startswith("magnitude of the turning speed")
        assert server.goals == []
        await pilot.press("ctrl+s")
        await until(form, pilot, lambda: server.goals)
        await pilot.press("ctrl+s")
        assert shown(form, "#state") == "a goal is running; Escape cancels it"
        server.goal.succeed()
        await until(form, pilot, lambda: form.last_words[0].startswith("succeeded"))

    fill_in(script)
    assert server.goal.request.angle == 9.0
    assert server.goal.request.angular_velocity == 0.0, "an empty field keeps its default"


def test_escape_cancels_the_goal_and_the_form_stays(ros: Any, fill_in: Any) -> None:
    """Another one can be sent."""
    server = ros.server()

    async def script(form: GoalFormApp, pilot: Pilot[Any]) -> None:
        await pilot.press("escape")
        assert shown(form, "#state") == "no goal is running; Ctrl-Q exits"
        await pilot.press("ctrl+s")
        await until(form, pilot, lambda: "accepted" in shown(form, "#state"))
        await pilot.press("escape")
        await until(form, pilot, lambda: shown(form, "#state").startswith("canceled: by you"))
        await pilot.press("ctrl+s")
        await until(form, pilot, lambda: len(server.goals) == 2)
        server.goal.abort()
        await until(form, pilot, lambda: "aborted" in shown(form, "#state"))
        await pilot.press("ctrl+c")

    form = fill_in(script, angle=30.0)
    assert form.return_value.how is GoalOutcome.ABORTED
    assert [goal.request.angle for goal in server.goals] == [30.0, 30.0]


def test_a_terminal_without_unicode_has_bars_in_ascii(ros: Any, fill_in: Any) -> None:
    """And lines."""
    server = ros.server()

    async def script(form: GoalFormApp, pilot: Pilot[Any]) -> None:
        await pilot.press("ctrl+s")
        await until(form, pilot, lambda: server.goals)
        server.goal.feed(current_angle=45.0, remaining_angle=45.0)
        await until(form, pilot, lambda: "##########.......... of 90" in _page(form))
        assert _page(form).isascii()
        server.goal.succeed()
        await until(form, pilot, lambda: form.last_words[0].startswith("succeeded"))

    fill_in(script, encoding="ascii")


@pytest.mark.parametrize("cancels", [True, None])
def test_leaving_cancels_the_goal_first(ros: Any, fill_in: Any, cancels: Any) -> None:
    """And waits for its end; the second time it leaves at once, and the goal is named."""
    ros.server(cancels=cancels)

    async def script(form: GoalFormApp, pilot: Pilot[Any]) -> None:
        await pilot.press("ctrl+s")
        await until(form, pilot, lambda: "accepted" in shown(form, "#state"))
        await pilot.press("ctrl+q")
        if cancels is None:
            form.serve()
            await pilot.press("ctrl+q")
        else:
            for _ in range(20):
                form.serve()

    form = fill_in(script)
    assert form.return_value.how is (GoalOutcome.CANCELED if cancels else GoalOutcome.LEFT)
    if cancels is None:
        assert "orphaned goal: /turn goal" in form.last_words[0]


def test_a_signal_leaves_as_ctrl_q_does(ros: Any, hand: Any, fill_in: Any) -> None:
    """SIGTERM, for one."""

    async def script(form: GoalFormApp, _: Pilot[Any]) -> None:
        hand.press_ctrl_c()
        form.serve()

    assert fill_in(script).return_value is None


def test_messages_that_have_a_short_form_are_one_line(fill_in: Any) -> None:
    """Its note says how it is written."""
    names: list[str] = []

    async def script(form: GoalFormApp, pilot: Pilot[Any]) -> None:
        names.extend(row.line.name for row in form.query(FormLine))
        assert "a pose [x m, y m, yaw deg]" in note(form, 0)
        await pilot.press(*"[1, 2]")
        assert note(form, 0) == "expected a pose [x m, y m, yaw deg], got a list of 2"

    fill_in(script, "nav2_msgs/action/NavigateToPose")
    assert names == ["pose", "behavior_tree"]


def test_truths_are_ticked(hand: Any) -> None:
    """With the space bar."""
    sent: list[Any] = []

    parts = tuple(
        InterfacePart(name, SetBool.Request, Section()) for name in ("goal", "result", "feedback")
    )

    class Sender:
        action = "/y"
        about = InterfaceDescription("x/action/Y", "", parts)

        def prepare(self, fields: Any) -> Any:
            sent.append(fields)
            raise BtMissionError("enough")

    sender: Any = Sender()
    form = GoalFormApp(hand, sender, {}, period_s=None)

    async def act() -> None:
        async with form.run_test(size=(20, 10)) as pilot:
            assert form.query_one(Checkbox).value is False
            await pilot.press("tab", "space", "ctrl+s")
            assert shown(form, "#state") == "not sent: enough"

    asyncio.run(act())
    assert sent == [{"data": True}]


def test_a_form_needs_a_terminal(ros: Any, type_in: Any) -> None:
    """In a pipe it says so."""
    ros.server()
    done = type_in("actions", "send", "/turn", "--form")
    assert done.code == 2
    assert "--form needs a terminal; give the goal as YAML instead" in done.err
