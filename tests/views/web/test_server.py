"""The server of pages: who gets in, what they are told, and what they can do to the mission."""

from __future__ import annotations

import asyncio
import json
import socket
from contextlib import closing
from functools import partial
from typing import Any

import pytest

from bt_mission.base.errors import BtMissionError
from bt_mission.executive.events.source import ControlRequest, Verb
from bt_mission.views.web import pages
from bt_mission.views.web.guarded_server import listening_socket
from bt_mission.views.web.live import LiveMission
from bt_mission.views.web.server import WebOptions, WebServer
from tests.support.watched import ScriptedExecutive, ScriptedGraph
from tests.support.web_pages import PageModel, closed, live, serve
from tests.support.web_scenes import served


def has_said(end: str, page: PageModel) -> bool:
    """Has the last leaf of the big tree said something with this end?"""
    words: str = page.nodes.get(400, [0, 0, ""])[2]
    return words.endswith(end)


@served
async def test_a_page_is_told_all_and_then_what_changes(
    server: WebServer, executive: ScriptedExecutive
) -> None:
    """The tree once, and of the nodes only those that have changed."""
    async with live(server) as connection:
        page = PageModel(connection)
        await page.until(lambda it: len(it.nodes) == 5)
        names = [node[0] for node in page.parts["tree"]["nodes"]]
        assert names == ["explore", "look around", "repeat", "drive", "turn away"]
        can = page.parts["state"]["can"]
        assert can == ["pause", "pause_keeping_goals", "stop", "breakpoint"]
        page.nodes.clear()
        executive.change(1.5, drive="running: 0.2 m")
        await page.until(lambda it: it.nodes)
        assert page.nodes == {3: [3, 1, "0.2 m", 1.5, None, None]}
        await page.until(lambda it: it.log)
        assert page.log[-1] == [1.5, 1, "drive", ""]


@served
async def test_two_pages_see_the_same_and_either_controls(
    server: WebServer, executive: ScriptedExecutive
) -> None:
    """The answer stands on both."""
    async with live(server) as item, live(server) as other:
        first, second = PageModel(item), PageModel(other)
        for page in (first, second):
            await page.until(lambda it: it.nodes)
        await first.ask("pause")
        await second.ask("breakpoint", node=3)
        await second.ask("breakpoint", node=99)
        for page in (first, second):
            await page.settle()
        assert executive.commands == [
            ControlRequest(Verb.PAUSE),
            ControlRequest(Verb.BREAK, "0.1.0"),
        ]
        executive.answer("breakpoint at '0.1.0'")
        for page in (first, second):
            await page.until(lambda it: "notice" in it.parts)
            assert page.parts["notice"] == [1, "breakpoint at 'drive'"]


def test_a_read_only_page_controls_nothing(executive: ScriptedExecutive, shown: LiveMission):
    """It may still look at whatever it likes."""

    async def scene(server: WebServer) -> None:
        async with live(server) as connection:
            page = PageModel(connection)
            await page.until(lambda it: it.nodes)
            assert page.parts["is_read_only"]
            for wish in ("pause", "resume", "step", "stop"):
                page.parts.pop("refusal", None)
                await page.ask(wish)
                await page.until(lambda it: "refusal" in it.parts)
            await page.ask("breakpoint", node=1)
            await page.ask("select", node=1)
            await page.until(lambda it: "node" in it.parts)
            await page.settle()
            assert executive.commands == []

    serve(shown, scene, WebOptions(port=0, is_read_only=True))


@pytest.mark.parametrize(
    ("message", "reason"),
    [
        ("", "the message is not JSON"),
        ("[" * 900, "the message is not JSON"),
        ("[1]", "not a request: expected an object with 'do'"),
        ('{"do": "rm -rf"}', "unknown request"),
        ('{"do": ["stop"]}', "not a request: expected an object with 'do'"),
        ('{"do": "pause", "x": 1}', "'pause' takes nothing"),
        ('{"do": "breakpoint"}', "'breakpoint' takes node"),
        ('{"do": "breakpoint", "node": -1}', "'node' is none"),
        ('{"do": "breakpoint", "node": true}', "'node' is none"),
        ('{"do": "select", "node": NaN}', "'node' is none"),
        ('{"do": "select", "node": 1e400}', "'node' is none"),
        (f'{{"do": "select", "node": {"9" * 400}}}', "'node' is none"),
        ('{"do": "go", "number": 1.5}', "unknown request"),
        (f'{{"do": "breakpoint", "node": {"9" * 400}}}', "'node' is none"),
        (
            f'{{"do": "attach", "name": "{"x" * 1000}"}}',
            "a message of 1028 characters, at most 1000",
        ),
        (b"\x00\xff", "the message is not text"),
    ],
)
@served
async def test_nonsense_ends_the_connection_with_a_reason(
    server: WebServer, executive: ScriptedExecutive, message: Any, reason: str
) -> None:
    """And nothing else: other pages and the mission go on."""
    async with live(server) as good:
        page = PageModel(good)
        async with live(server) as bad:
            await bad.send(message)
            assert await closed(bad) == (1003, reason)
        executive.change(1.0, drive="running")
        await page.until(lambda it: it.nodes.get(3, [0, 0])[1] == 1)
        assert executive.commands == []


@pytest.mark.thorough
@served
async def test_a_million_messages_are_cut_short(
    server: WebServer, executive: ScriptedExecutive
) -> None:
    """A page that asks more than a hand can is closed; what it has asked until then is little."""
    async with live(server) as flood:

        async def send() -> None:
            for _ in range(1_000_000):
                await flood.send('{"do": "step"}')

        sending = asyncio.create_task(send())
        assert await closed(flood) == (1008, "more than 20 messages a second")
        await asyncio.gather(sending, return_exceptions=True)
    assert 0 < len(executive.commands) < 200


@served
async def test_a_message_without_end_is_cut_short(
    server: WebServer, executive: ScriptedExecutive
) -> None:
    """Before it fills the memory."""
    async with live(server) as flood:
        sending = asyncio.create_task(flood.send("x" * 10_000_000))
        code, _ = await closed(flood)
        await asyncio.gather(sending, return_exceptions=True)
        assert code == 1009


@served
async def test_a_page_that_does_not_read_holds_up_nobody(
    server: WebServer, executive: ScriptedExecutive
) -> None:
    """It is told the newest later, not everything in between."""
    executive.outline = "root\n" + "".join(f"  leaf {number}\n" for number in range(400))
    executive.begin("big")
    names = [f"leaf_{number}" for number in range(400)]
    slow_socket = socket.create_connection(("127.0.0.1", server.port))
    slow_socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 200_000)
    async with (
        live(server) as quick,
        live(server, sock=slow_socket, max_queue=1, ping_interval=None) as slow,
    ):
        page = PageModel(quick)
        for turn in range(40):
            executive.change(0.1, **dict.fromkeys(names, f"running: {'x' * 2000} {turn}"))
            await page.until(partial(has_said, f" {turn}"))
        late = PageModel(slow)
        await late.until(partial(has_said, " 39"))
        assert late.messages < 30


@served
async def test_a_page_that_comes_again_catches_up(
    server: WebServer, executive: ScriptedExecutive
) -> None:
    """With all that has happened meanwhile."""
    async with live(server) as connection:
        await PageModel(connection).until(lambda it: it.nodes)
    executive.change(1.0, look_around="running")
    executive.change(1.0, look_around="success: done", drive="running")
    executive.detail(variables=(("speed", "0.2"),))
    async with live(server) as connection:
        page = PageModel(connection)
        await page.until(lambda it: it.variables)
        assert page.nodes[1] == [1, 2, "done", 2.0, 1.0, None]
        assert page.nodes[3][1] == 1
        assert page.variables == {"speed": "0.2"}
        assert [line[2] for line in page.log[-3:]] == ["look around", "look around", "drive"]


@served
async def test_no_more_pages_than_can_be_served(
    server: WebServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The others are told why."""
    monkeypatch.setattr(pages, "MOST_PAGES", 1)
    async with live(server) as first, live(server) as second:
        assert await closed(second) == (1013, "1 pages are already open")
        assert json.loads(await first.recv())


def test_the_look_at_the_mission_that_fails_ends_the_server(shown: LiveMission):
    """With what has failed, for whoever runs it."""

    def fail() -> None:
        raise BtMissionError("the graph is gone")

    graph = shown._graph
    graph.serve = fail  # type: ignore[method-assign]

    async def scene(server: WebServer) -> None:
        async with live(server) as connection:
            await closed(connection)

    with pytest.raises(BtMissionError, match="the graph is gone"):
        serve(shown, scene)


@served
async def test_a_page_that_cannot_be_told_is_closed_with_the_reason(
    server: WebServer, shown: LiveMission
) -> None:
    """The others, and the server, go on."""
    async with live(server) as item:
        await PageModel(item).until(lambda it: it.nodes)
        shown.board._parts.put("broken", object(), shown.board.revision + 1)
        shown.board.revision += 1
        reason = "the server failed: TypeError: Object of type object is not JSON serializable"
        assert await closed(item) == (1011, reason)
    shown.board._parts.put("broken", 0, shown.board.revision + 1)
    async with live(server) as other:
        await PageModel(other).until(lambda it: it.nodes)


def test_a_port_that_is_taken_is_said_with_a_free_one():
    """The next that can be had."""
    with listening_socket("127.0.0.1", 0) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(BtMissionError) as error:
            listening_socket("127.0.0.1", port)
    output = str(error.value)
    assert output.startswith(f"--port {port}: the port is in use; --port ")
    assert output.endswith(" is free")


def test_an_address_of_another_machine_is_no_place_to_listen():
    """With what to do instead."""
    with pytest.raises(BtMissionError, match=r"--host 192\.0\.2\.1: cannot listen on this address"):
        listening_socket("192.0.2.1", 0)


class Frames:
    """Counts the frames of a server, and ends it."""

    def __init__(self) -> None:
        self.count = self._wanted = 0
        self._reached = asyncio.Event()
        self.is_over = False

    async def pass_by(self, count: int) -> None:
        """Wait until so many more have passed."""
        self._wanted, self._reached = self.count + count, asyncio.Event()
        await self._reached.wait()

    def until(self) -> bool:
        """Is the server to end? It asks once a frame."""
        self.count += 1
        if self.count >= self._wanted:
            self._reached.set()
        return self.is_over


def test_hardly_anything_is_looked_at_while_no_page_is_open(
    shown: LiveMission, executive: ScriptedExecutive
):
    """Only now and then, so that nothing piles up; who opens a page is told the newest."""
    graph = shown._graph
    assert isinstance(graph, ScriptedGraph)

    async def scene(server: WebServer, frames: Frames) -> None:
        await frames.pass_by(100)
        assert 0 < graph.served < frames.count / 2
        executive.change(1.0, drive="running")
        async with live(server) as socket:
            page = PageModel(socket)
            await page.until(lambda page: page.nodes and page.nodes[3][1] == 1)
            begun, served = frames.count, graph.served
            await frames.pass_by(20)
            assert graph.served - served >= frames.count - begun - 1

    async def play() -> None:
        frames = Frames()
        with closing(WebServer(shown, WebOptions(port=0, frame_s=0.001))) as server:
            serving = asyncio.create_task(server.serve(frames.until))
            try:
                await asyncio.wait_for(scene(server, frames), 60)
            finally:
                frames.is_over = True
                await serving

    asyncio.run(play())
