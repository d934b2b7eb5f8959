"""The page in a browser, where there is one: every control, the tree, two browsers.

Also for keys, screen readers and narrow screens.
"""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Any

import pytest

from bt_mission.executive.events.source import ControlRequest, Verb
from bt_mission.views.web.live import LiveMission
from bt_mission.views.web.server import WebOptions, WebServer
from tests.support.browser import IN_BROWSER, Page, browser
from tests.support.watched import ScriptedExecutive, ScriptedGraph
from tests.support.web_pages import serve
from tests.support.web_scenes import scene_on_page
from tests.support.web_screen import Screen

pytestmark = IN_BROWSER


@scene_on_page()
async def test_every_control_of_a_mission(screen: Screen, executive: ScriptedExecutive) -> None:
    """Each button and each key sends its wish; stop only when it is asked for twice."""

    async def sent(verb: Verb, node: str = "") -> None:
        for _ in range(200):
            if executive.commands:
                break
            await screen.look("0")
        assert executive.commands == [ControlRequest(verb, node)]
        executive.commands.clear()

    for button, verb in (("pause", Verb.PAUSE), ("pause_keeping_goals", Verb.PAUSE_KEEPING_GOALS)):
        await screen.click(button)
        await sent(verb)
    await screen.key("p")
    await sent(Verb.PAUSE)
    executive.stand("paused", "asked for")
    await screen.until("document.getElementById('pause').disabled")
    await screen.shows("status", "paused")
    await screen.shows("reason", "asked for")
    for button, verb in (("resume", Verb.RESUME), ("step", Verb.STEP)):
        await screen.click(button)
        await sent(verb)
    await screen.key("s")
    await sent(Verb.STEP)
    await screen.click("stop")
    await screen.shows("notice", "Stop again stops the mission")
    await screen.look("document.getElementById('tree').click()")
    await screen.click("stop")
    await screen.look("document.dispatchEvent(new KeyboardEvent('keydown', {key: 'z'}))")
    assert executive.commands == [], "anything else does not"
    await screen.key("x")
    await screen.key("x")
    await sent(Verb.STOP)
    await screen.look("document.getElementById('node-3').click()")
    await screen.click("breakpoint")
    await sent(Verb.BREAK, "0.1.0")
    executive.detail(breakpoints=("0.1.0",))
    await screen.until("document.querySelector('#node-3 .stop').textContent === '●'")
    await screen.key("b")
    await sent(Verb.UNBREAK, "0.1.0")
    executive.answer("no breakpoint at '0.1.0' any more")
    await screen.shows("notice", "no breakpoint at 'drive' any more")
    executive.stand("success", "done")
    for name in ("pause", "resume", "step", "stop", "breakpoint"):
        await screen.until(f"document.getElementById({name!r}).disabled")


@scene_on_page()
async def test_the_tree_as_a_drawing(screen: Screen, executive: ScriptedExecutive) -> None:
    """It has the nodes, the breakpoints and the selection of the outline."""
    await screen.look("document.getElementById('node-3').click()")
    executive.detail(breakpoints=("0.1.0",))
    await screen.key("d")  # the same tree as a drawing, with the same selection
    await screen.until("document.querySelector('#box-3[aria-label*=breakpoint]') !== null")
    assert await screen.look("document.querySelectorAll('.node').length") == 5
    assert (
        await screen.look("document.activeElement.getAttribute('aria-activedescendant')") == "box-3"
    )
    await screen.key("ArrowDown")
    await screen.until("document.querySelector('#node-4[aria-selected=true]') !== null")
    await screen.key("ArrowUp")
    await screen.key("d")
    await screen.until("document.activeElement.id === 'tree'")


def test_of_a_fleet_the_robot_that_is_shown_is_marked(chromium: Page):
    """A button lasts while the mission goes on, so that no press of it is lost."""
    first, other = ScriptedExecutive(name="/one"), ScriptedExecutive(name="/two")
    first.begin()
    other.begin()
    shown = LiveMission(ScriptedGraph(first, other), "/one", is_fleet=True)
    shown.attach("/one")
    marked = "document.querySelector('#choice-list [aria-pressed=true]')?.textContent === {!r}"

    async def visited(server: WebServer) -> None:
        screen = Screen(chromium)
        await screen.visit(server.link)
        await screen.until(marked.format("/one"))
        await screen.look("document.querySelectorAll('#choice-list button')[1].focus()")
        first.stand("paused", "asked for")
        await screen.shows("status", "paused")
        await screen.look("document.activeElement.click()")
        await screen.until(marked.format("/two"))

    serve(shown, visited, WebOptions(port=0))
    assert chromium.problems == []


def test_the_page_waits_for_a_mission(chromium: Page):
    """And says so, rather than to stand there empty."""
    executive = ScriptedExecutive()
    executive.stand("idle")
    shown = LiveMission(ScriptedGraph(executive))

    async def visited(server: WebServer) -> None:
        screen = Screen(chromium)
        await screen.visit(server.link)
        await screen.shows("hint", "No mission runs")

    serve(shown, visited, WebOptions(port=0))


@scene_on_page()
async def test_the_page_says_what_its_keys_do(screen: Screen, executive: ScriptedExecutive) -> None:
    """Those that it has now; no other key does anything meanwhile."""
    await screen.key("?")
    await screen.until("document.getElementById('keys').open")
    output = await screen.look("document.getElementById('keys').innerText")
    assert "stop the mission" in output
    assert "play or pause" not in output, "that is of recordings"
    await screen.key("p")
    await screen.key("?")
    await screen.until("!document.getElementById('keys').open")
    assert executive.commands == []
    await screen.click("show-keys")
    await screen.click("close-keys")
    await screen.until("!document.getElementById('keys').open")
    titles = await screen.look(
        "[...document.querySelectorAll('#live-controls button')]"
        ".map((one) => one.title.endsWith(`(${one.getAttribute('aria-keyshortcuts')})`))"
    )
    assert titles == [True] * 6


@scene_on_page(is_read_only=True)
async def test_a_read_only_page_has_no_controls(
    screen: Screen, executive: ScriptedExecutive
) -> None:
    """And its keys do nothing."""
    await screen.until("document.getElementById('live-controls').hidden")
    assert await screen.look("document.getElementById('live-keys').hidden")
    await screen.key("p")
    await screen.look("document.getElementById('fold').click()")
    assert executive.commands == []


@pytest.mark.process(always=True)
@scene_on_page()
async def test_it_follows_what_runs(screen: Screen, executive: ScriptedExecutive) -> None:
    """Until somebody selects by hand; the panel of the node says all of it."""
    executive.change(1.0, look_around="running: 3 of 8")
    selected = "document.querySelector('.row[aria-selected=true]').id"
    await screen.until(f"{selected} === 'node-1'")
    await screen.shows("node", "3 of 8")
    executive.change(2.0, look_around="success: seen", drive="running")
    await screen.until(f"{selected} === 'node-3'")
    await screen.look("document.getElementById('node-1').click()")
    await screen.shows("node", "at 3.00 s, ran 2.0 s")
    executive.change(1.0, drive="failure: blocked", turn_away="running")
    await screen.until("document.getElementById('node-3').dataset.status === 'failure'")
    assert await screen.look(selected) == "node-1"
    await screen.shows("log", "blocked")


def test_two_browsers_and_one_that_loses_its_connection(
    chromium: Page, shown: LiveMission, executive: ScriptedExecutive, tmp_path: Path
):
    """Both show the same; the one that was cut off comes back by itself, and catches up."""
    with browser(tmp_path / "other") as second:
        screens = [Screen(chromium), Screen(second)]

        async def scene(server: WebServer) -> None:
            for screen in screens:
                await screen.visit(server.link)
                await screen.until("document.querySelectorAll('.row').length === 5")
            executive.change(1.0, drive="running")
            for screen in screens:
                await screen.until("document.getElementById('node-3').dataset.status === 'running'")
            for page in tuple(server.pages.all):
                await page._socket.close(1012, "a test")
            executive.change(1.0, drive="success: there", turn_away="running")
            for screen in screens:
                await screen.until("document.getElementById('node-4').dataset.status === 'running'")
                await screen.shows("connection", "connected")

        serve(shown, scene)
        assert second.problems == []


def test_a_page_of_an_earlier_start_says_so(chromium: Page, executive: ScriptedExecutive):
    """It does not knock for ever at a server that does not know it."""
    screen = Screen(chromium)
    ports = []

    async def first(server: WebServer) -> None:
        ports.append(server.port)
        await screen.visit(server.link)

    async def second(_: WebServer) -> None:
        await screen.shows("connection", "open the link that the command printed")

    serve(LiveMission(ScriptedGraph(executive)), first)
    again = LiveMission(ScriptedGraph(executive))
    serve(again, second, WebOptions(port=ports[0]))


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_it_is_light_or_dark_as_the_browser_is_and_fits_a_phone(
    chromium: Page, shown: LiveMission, scheme: str
):
    """No part of it is wider than the screen; a click turns it round."""
    chromium.prefer(scheme)

    async def scene(server: WebServer) -> None:
        screen = Screen(chromium)
        await screen.visit(server.link, width=390, height=800)
        await screen.until("document.querySelectorAll('.row').length === 5")
        assert await screen.look("document.documentElement.dataset.theme") == scheme
        assert await screen.look("document.documentElement.scrollWidth") <= 390
        await screen.click("theme")
        assert await screen.look("document.documentElement.dataset.theme") != scheme

    serve(shown, scene)


@scene_on_page()
async def test_ten_thousand_nodes(screen: Screen, executive: ScriptedExecutive) -> None:
    """Only the rows in view are in the page, and the last node is reached at once."""
    executive.outline = "root\n" + "".join(f"  leaf {number}\n" for number in range(10_000))
    executive.begin("big")
    await screen.until("document.querySelectorAll('.row').length > 10")
    executive.change(1.0, leaf_9999="running: here")
    await screen.until("document.getElementById('node-10000')?.dataset.status === 'running'")
    for turn in range(20):
        executive.change(0.1, **{f"leaf_{turn * 500}": "running"})
        await screen.until(f"document.getElementById('node-{turn * 500 + 1}') !== null")
    assert await screen.look("document.querySelectorAll('.row').length") < 100


@scene_on_page()
async def test_the_tree_is_one_for_keys_and_for_screen_readers(screen: Screen) -> None:
    """It has the roles and levels of a tree, and what is selected is said."""
    reported = await screen.look(
        "[...document.querySelectorAll('[role=tree] [role=treeitem]')].map((one) => "
        "['aria-level', 'aria-posinset', 'aria-setsize', 'aria-expanded'].map("
        "(name) => one.getAttribute(name)))"
    )
    assert reported == [
        ["1", "1", "1", "true"],
        ["2", "1", "2", None],
        ["2", "2", "2", "true"],
        ["3", "1", "2", None],
        ["3", "2", "2", None],
    ]
    active = "document.getElementById('tree').getAttribute('aria-activedescendant')"
    await screen.look("document.getElementById('tree').focus()")
    for key, selected in (
        ("End", 4), ("Home", 0), ("ArrowDown", 1), ("ArrowDown", 2), ("ArrowRight", 3),
        ("ArrowLeft", 2), ("ArrowLeft", 2), ("ArrowDown", 2), ("Enter", 2), ("PageDown", 4),
    ):  # fmt: skip
        await screen.key(key)
        await screen.until(f"{active} === 'node-{selected}'")
    await screen.key("Home")
    await screen.key("ArrowLeft")
    assert await screen.look("document.querySelectorAll('.row').length") == 1
    label = await screen.look("document.getElementById('node-0').getAttribute('aria-label')")
    assert label == "explore, ActionLeaf, idle"
    await screen.key("/")
    await screen.look(
        "(() => { const box = document.activeElement; box.value = 'TURN';"
        " box.dispatchEvent(new Event('input')); })()"
    )
    await screen.until(f"{active} === 'node-4'")
    await screen.look(
        "(() => { const box = document.getElementById('search'); box.value = 'nothing';"
        " box.dispatchEvent(new Event('input')); })()"
    )
    await screen.shows("found", "not in the tree")


def accessible_nodes(page: Page) -> list[tuple[str, str, dict[str, Any]]]:
    """What a screen reader is told of a page: roles, names and properties, in order."""
    nodes = page.call("Accessibility.getFullAXTree")["nodes"]
    return [
        (
            node["role"]["value"],
            node.get("name", {}).get("value", ""),
            {each["name"]: each["value"].get("value") for each in node.get("properties", ())},
        )
        for node in nodes
        if not node["ignored"] and "role" in node
    ]


@scene_on_page()
async def test_what_a_screen_reader_is_told(screen: Screen, executive: ScriptedExecutive) -> None:
    """The tree with its levels, every control by a name, and no time that is said all the time."""
    executive.change(1.0, drive="running: 0.4 m")
    executive.detail(variables=(("speed", "0.1"),))
    executive.judge(is_slow="violated -0.1")
    await screen.shows("variables", "speed")
    await screen.shows("requirements", "is slow")
    await screen.look("document.getElementById('tree').focus()")
    reports = await asyncio.to_thread(accessible_nodes, screen.page)
    items = [
        (name, *map(facts.get, ("level", "expanded", "selected")))
        for role, name, facts in reports
        if role == "treeitem"
    ]
    assert items == [
        ("explore, ActionLeaf, idle", 1, True, False),
        ("look around, ActionLeaf, idle", 2, None, False),
        ("repeat, ActionLeaf, idle", 2, True, False),
        ("drive, ActionLeaf, running, 0.4 m", 3, None, True),
        ("turn away, ActionLeaf, idle", 3, None, False),
    ]
    ((tree, facts),) = [(name, facts) for role, name, facts in reports if role == "tree"]
    assert (tree, facts["focused"]) == ("Tree", True)
    named = {"button", "searchbox", "checkbox", "slider", "list", "region", "navigation"}
    assert [report for report in reports if report[0] in named and not report[1]] == []
    assert {name for role, name, _ in reports if role == "button"} >= {"Map", "Camera", "Pause"}
    lives = "[...document.querySelectorAll('output')].map((one) => one.ariaLive)"
    assert await screen.look(lives) == ["off"], "the time goes on and on"


@scene_on_page()
async def test_a_row_that_changes_stays_the_same_element(
    screen: Screen, executive: ScriptedExecutive
) -> None:
    """Or a screen reader would read the selected one again with each change."""
    await screen.look("window.row = document.getElementById('node-3')")
    executive.change(1.0, drive="running: 0.4 m")
    await screen.until("document.getElementById('node-3').dataset.status === 'running'")
    assert await screen.look("window.row === document.getElementById('node-3')")


@scene_on_page(width=360)
async def test_nothing_is_wider_than_a_narrow_phone(
    screen: Screen, executive: ScriptedExecutive
) -> None:
    """However long the texts of a mission are; only the tree scrolls within itself."""
    long = "x" * 200
    executive.change(1.0, drive=f"running: {long}")
    executive.detail(variables=((long, f'"{long}"'),))
    executive.judge(**{long: "violated -0.1"})
    executive.stand("paused", long)
    executive.answer(long)
    executive.say(long)
    for name in ("variables", "requirements", "reason"):
        await screen.shows(name, long)
    assert await screen.look("document.documentElement.scrollWidth") <= 360
    wide = "[...document.querySelectorAll('body *')].filter((one) => !one.closest('#tree')"
    wide += " && one.offsetParent && one.getBoundingClientRect().right > 361).length"
    assert await screen.look(wide) == 0
