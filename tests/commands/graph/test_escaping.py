"""Every text of every message that the commands for actions, topics and services show."""

from __future__ import annotations

import asyncio
import importlib
import inspect
import io
import json
import typing
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import pytest

from bt_mission.base.text import columns
from bt_mission.commands.graph import goal_events, listing
from bt_mission.commands.graph.form import GoalFormApp
from bt_mission.commands.graph.goal_views import goal_view_for, on_a_line
from bt_mission.commands.graph.graph_query import GraphEntry
from bt_mission.commands.graph.interface_description import (
    InterfaceDescription,
    InterfacePart,
    describe_interface,
)
from bt_mission.commands.graph.values import as_json, as_yaml, plain
from bt_mission.language.interface_comments import read_interface
from tests.support.hostile import (
    HOSTILE,
    MARK,
    SHORT,
    escape_nothing,
    fill,
    filled,
    leaks,
    texts_in,
)
from tests.support.thorough import sample

PACKAGES = (
    "bt_mission_interfaces",
    "nav2_msgs",
    "example_interfaces",
    "std_msgs",
    "rcl_interfaces",
)
ENDS = {"msg": ("",), "srv": ("Request", "Response"), "action": ("Goal", "Result", "Feedback")}


def messages() -> Iterator[tuple[str, Any]]:
    """The class of each message, and of each part of a service or an action, by its name."""
    for package in PACKAGES:
        for sort, parts in ENDS.items():
            try:
                module = importlib.import_module(f"{package}.{sort}")
            except ImportError:
                continue
            for name, cls in inspect.getmembers(module, inspect.isclass):
                if sort == "msg" or not name.endswith(("_Event", *ENDS["srv"], *ENDS["action"])):
                    for part in parts:
                        yield f"{package}/{sort}/{name}{part}", getattr(cls, part) if part else cls


WITH_TEXTS = {name: cls for name, cls in messages() if texts_in(fill(cls()))}
ACTIONS = sorted({name.removesuffix("Feedback") for name, _ in messages() if "Feedback" in name})


def test_the_walk_finds_what_is_there():
    """Results, feedback, logs and our own status messages have texts."""
    assert {
        "bt_mission_interfaces/action/TurnResult",
        "bt_mission_interfaces/action/ExecuteMissionFeedback",
        "bt_mission_interfaces/msg/Tree",
        "bt_mission_interfaces/msg/MissionDetails",
        "rcl_interfaces/msg/Log",
        "std_msgs/msg/String",
    } <= set(WITH_TEXTS)
    assert "bt_mission_interfaces/action/Turn" in ACTIONS


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    encoding = "utf-8"

    def isatty(self) -> bool:
        return True


def events(goal: Any, result: Any, feedback: Any) -> Iterator[Any]:
    """Every event of a goal, with all its texts hostile; feedback of our own goal, and others'."""
    yield from (filled(kind) for kind in typing.get_args(goal_events.GoalEvent))
    yield goal_events.FeedbackReceived(feedback, 1.0)
    yield goal_events.FeedbackReceived(feedback, 1.0, HOSTILE)
    how = goal_events.GoalOutcome.ABORTED
    yield goal_events.GoalEnded(goal_events.GoalResult(how, HOSTILE, result), 2.0)
    yield goal_events.GoalEnded(goal_events.GoalResult(how, HOSTILE, None), 2.0)


def shown_events(type_name: str, view: str) -> str:
    """What a view shows of a hostile goal."""
    stream = io.StringIO() if view in ("lines", "json") else Terminal()
    about = describe_interface(type_name)
    goal, result, feedback = (
        fill(about.part(part).cls()) for part in ("goal", "result", "feedback")
    )
    shower = goal_view_for(stream, about, goal, json=view == "json", plain=False)
    shower_events = [shown for shown in events(goal, result, feedback) if _is_whole(shown)]
    for event in shower_events:
        shower.show(event)
    shower.close()
    return stream.getvalue()


def _is_whole(event: Any) -> bool:
    """Whether the event holds messages, and not a text in the place of one."""
    end = getattr(event, "end", None)
    return not isinstance(getattr(event, "message", None), str) and not isinstance(
        getattr(end, "result", None), str
    )


@pytest.mark.parametrize("view", ["lines", "json", "picture"])
@pytest.mark.parametrize("type_name", ACTIONS)
def test_goals_of_actions(type_name, view, monkeypatch):
    """Live, in lines, as objects; goal, feedback, result, and what the server gives as reason."""
    monkeypatch.setenv("TERM", "xterm-256color")
    monkeypatch.setenv("COLUMNS", "400")
    shown = shown_events(type_name, view)
    assert MARK in shown
    assert leaks(shown, is_coloured=view == "picture") == []
    if view == "json":
        assert HOSTILE in str([json.loads(line) for line in shown.splitlines()][-1]["reason"])


@pytest.mark.parametrize("view", ["lines", "picture"])
def test_goals_can_leak(view, monkeypatch):
    """Where nothing is escaped, it is noticed."""
    monkeypatch.setenv("TERM", "xterm-256color")
    escape_nothing(monkeypatch)
    assert leaks(shown_events("bt_mission_interfaces/action/Turn", view), is_coloured=True)


@pytest.mark.parametrize("name", sample(WITH_TEXTS, 3))
def test_messages(name):
    """As YAML, on one line, and as JSON, which gives back what came."""
    values = plain(fill(WITH_TEXTS[name]()))
    for shown in (as_yaml(values), on_a_line(fill(WITH_TEXTS[name]()), {}), as_json(values)):
        assert leaks(shown) == []
        assert MARK in shown
    assert json.loads(as_json(values)) == values


def test_messages_can_leak(monkeypatch):
    """Where nothing is escaped, it is noticed."""
    escape_nothing(monkeypatch)
    assert leaks(on_a_line(fill(WITH_TEXTS["std_msgs/msg/String"]()), {}))


def hostile_interface() -> InterfaceDescription:
    """A description whose every text is hostile: comments, units, named values."""
    known = describe_interface("bt_mission_interfaces/action/Turn")
    comment = HOSTILE.replace("\n", " ").replace("\r", " ")
    text = f"# {comment}\nfloat32 angle # {comment}\nuint16 A=1 # {comment}\nstring B={comment}\n"
    interface = read_interface(text)
    parts = tuple(InterfacePart(part.name, part.cls, interface.section(0)) for part in known.parts)
    return InterfaceDescription(HOSTILE, HOSTILE, parts)


@pytest.mark.parametrize("kind", ["action", "topic", "service"])
def test_lists_of_the_graph(kind, capsys):
    """Names, types and nodes, as tables and as objects."""
    entry = filled(GraphEntry)
    lines = columns(listing.entry_rows(kind, [entry, entry]))
    lines.append(as_json(listing.entry_object(kind, entry)))
    assert all(MARK in line for line in lines if "publishers" not in line)
    assert leaks("\n".join(lines)) == []


def test_descriptions_of_actions():
    """Comments of an interface file, as text and as an object."""
    entry, about = filled(GraphEntry), hostile_interface()
    shown = "\n".join(listing.info_lines(entry, about))
    assert shown.count(MARK) > 6
    assert leaks(shown) == []
    assert leaks(as_json(listing.info_object(entry, about))) == []


# ---- the form for a goal ---------------------------------------------------------------------


def form_of(text: str) -> str:
    """What the form for a goal shows: names, comments, what was typed, and what comes of it."""
    about = hostile_interface()
    sender: Any = SimpleNamespace(action=text, about=about)
    session: Any = SimpleNamespace(interrupts=SimpleNamespace(count=0), now_ns=0)
    form = GoalFormApp(session, sender, {"angle": text}, period_s=None)

    async def scene() -> list[str]:
        rows = []
        async with form.run_test(size=(400, 60)) as pilot:
            for event in events(None, fill(about.part("result").cls(), text), None):
                if _is_whole(event) and not isinstance(event, goal_events.FeedbackReceived):
                    form.show(event)
                    await pilot.pause()
                    rows += [strip.text for strip in form.screen._compositor.render_strips()]
        return rows

    return "\n".join(asyncio.run(scene()))


def test_the_form_for_a_goal():
    """Its widgets show no markup, and nothing of what they hold commands the terminal."""
    shown = form_of(MARK + SHORT + "[reverse]m[/]")
    assert "MARK\\x1b]52;c;A" in shown
    assert "[reverse]m[/]" in shown
    assert leaks(shown) == []


def test_the_form_can_leak(monkeypatch):
    """Where nothing is escaped, it is noticed."""
    escape_nothing(monkeypatch)
    assert leaks(form_of(MARK + SHORT))
