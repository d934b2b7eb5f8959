"""The page for keys, screen readers and narrow screens, in headless Chromium."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest

from bt_mission.views.web.live import LiveMission
from bt_mission.views.web.server import WebServer
from tests.support.browser import BROWSER, Page
from tests.support.watched import ScriptedExecutive
from tests.support.web_pages import serve
from tests.support.web_scenes import scene_on_page
from tests.support.web_screen import Screen

pytestmark = [
    pytest.mark.process,
    pytest.mark.skipif(BROWSER is None, reason="no Chromium is installed"),
]


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


def test_nothing_is_wider_than_a_narrow_phone(
    chromium: Page, shown: LiveMission, executive: ScriptedExecutive
):
    """However long the texts of a mission are; only the tree scrolls within itself."""
    long = "x" * 200
    executive.change(1.0, drive=f"running: {long}")
    executive.detail(variables=((long, f'"{long}"'),))
    executive.judge(**{long: "violated -0.1"})
    executive.stand("paused", long)
    executive.answer(long)
    executive.say(long)

    async def scene(server: WebServer) -> None:
        screen = Screen(chromium)
        await screen.visit(server.link, width=360, height=740)
        await screen.shows("variables", long)
        await screen.shows("requirements", long)
        await screen.shows("reason", long)
        assert await screen.look("document.documentElement.scrollWidth") <= 360
        wide = "[...document.querySelectorAll('body *')].filter((one) => !one.closest('#tree')"
        wide += " && one.offsetParent && one.getBoundingClientRect().right > 361).length"
        assert await screen.look(wide) == 0

    serve(shown, scene)
