"""The panels of the page in a browser: history, values, map, camera; no text is markup."""

from __future__ import annotations

import pytest

from bt_mission.executive.events import messages
from bt_mission.views.web.live import LiveMission, OpenPanels
from bt_mission.views.web.server import WebServer
from tests.support.browser import IN_BROWSER, Page
from tests.support.watched import ScriptedExecutive, goal_in
from tests.support.web_pages import serve
from tests.support.web_scenes import scene_on_page
from tests.support.web_screen import Screen

pytestmark = IN_BROWSER

HOSTILE = "<img src=x onerror=document.title='owned'>&amp;<script>document.title='owned'</script>"


@scene_on_page()
async def test_the_history_since_the_page_was_opened_can_be_looked_at(
    screen: Screen, executive: ScriptedExecutive
) -> None:
    """While the mission goes on; one click leads back to the present."""
    for name, after in (("look_around", "drive"), ("drive", "turn_away")):
        executive.change(2.0, **{name: "success", after: "running"})
        index = executive.names.index(after.replace("_", " "))
        await screen.until(f"document.getElementById('node-{index}').dataset.status === 'running'")
    await screen.until("Number(document.getElementById('time').max) >= 4")
    await screen.slide(3)
    await screen.until("document.getElementById('node-3').dataset.status === 'running'")
    assert await screen.look("document.getElementById('node-4').dataset.status") == "idle"
    await screen.shows("at", "the past; the mission is running")
    executive.change(1.0, turn_away="failure: no room")
    await screen.click("live")
    await screen.until("document.getElementById('node-4').dataset.status === 'failure'")


def test_a_page_opened_after_the_end_goes_back_through_the_run(
    chromium: Page, shown: LiveMission, executive: ScriptedExecutive
):
    """The server sends it the changes of nodes since the mission's start."""
    executive.change(1.0, look_around="running")
    executive.change(2.0, look_around="success", drive="running")
    executive.change(1.0, drive="failure: blocked", explore="failure")
    executive.stand("failure", "blocked")
    shown.look(OpenPanels())

    async def scene(server: WebServer) -> None:
        screen = Screen(chromium)
        await screen.visit(server.link)
        await screen.until("document.getElementById('node-3')?.dataset.status === 'failure'")
        await screen.shows("at", "the end")
        await screen.slide(2)
        statuses = "[...document.querySelectorAll('.row')].map((row) => row.dataset.status)"
        await screen.until(f"{statuses}[1] === 'running'")
        assert await screen.look(statuses) == ["idle", "running", "idle", "idle", "idle"]
        assert await screen.look("document.getElementById('time').min") == "0"
        await screen.shows("at", "the past")

    serve(shown, scene)
    assert chromium.problems == []


@scene_on_page()
async def test_values_goals_requirements_and_the_map(
    screen: Screen, executive: ScriptedExecutive
) -> None:
    """A variable against time, with gaps; the map, which is open where there is room."""
    goal = goal_in("active", (1.0, 1.0), goal_id="0123456789", action="/drive", owner="drive")
    executive.judge(is_slow="violated -0.1", has_room="open 0.5")
    for value in ("0.1", "0.25", "inf", "0.2"):
        executive.detail(0.5, goals_sent=1, goals=(goal,), variables=(("speed", value),))
        await screen.shows("variables", value)
    await screen.shows("goals", "active")
    await screen.shows("goals-title", "Goals: 1 sent, 1 open")
    await screen.shows("requirements", "violated is slow")
    await screen.shows("figures", " · 1 of 2 requirements violated")
    assert await screen.look("document.querySelector('#requirements code').textContent")
    await screen.look("document.querySelector('#variables button').click()")
    await screen.shows("chart-title", "speed: 0.1 to 0.25, and not finite")
    lines = "[...document.querySelectorAll('#chart-drawing polyline')]"
    await screen.until(f"{lines}.map((one) => one.points.length).join() === '4,2'")
    executive.show(
        (messages.FrameTransform("map", "base_link", 1.5, 0.25, 0.0),),
        messages.Map(1.0, 3, 2, 0.0, 0.0, 0.0, bytes([0, 100, 0, 255, 0, 0])),
    )
    await screen.shows("map-title", "Map: x 1.50  y 0.25 m")
    painted = (
        "(() => { const map = document.getElementById('map');"
        " const data = map.getContext('2d').getImageData(0, 0, map.width, map.height).data;"
        " return data.some((one) => one > 0); })()"
    )
    await screen.until(painted)


@scene_on_page()
async def test_zones_and_waypoints_are_on_the_map(
    screen: Screen, executive: ScriptedExecutive
) -> None:
    """A zone in its colour where it is, under its name; a waypoint with its number."""
    executive.show(
        messages.Map(1.0, 4, 4, 0.0, 0.0, 0.0, bytes(16)),
        messages.Zones((messages.ZoneDisc(HOSTILE, 1.0, 1.0, 0.5, "#00c000"),)),
    )
    share = (
        "(() => { const map = document.getElementById('map');"
        " const copy = new OffscreenCanvas(map.width, map.height);"
        " const context = copy.getContext('2d', { willReadFrequently: true });"
        " context.drawImage(map, 0, 0);"
        " const data = context.getImageData(0, 0, map.width, map.height).data;"
        " let [count, left, low] = [0, 0, 0];"
        " for (let at = 0; at < data.length; at += 4) {"
        "  if (data[at + 3] < 50 || !TEST) continue;"
        "  count++; left += (at / 4) % map.width; low += Math.floor(at / 4 / map.width); }"
        " return [count, left / count / map.width, low / count / map.height]; })()"
    )
    green = share.replace("TEST", "(data[at + 1] > 150 && data[at] < 60 && data[at + 2] < 60)")
    await screen.until(f"{green}[0] > 100")
    _, left, low = await screen.look(green)
    assert 0.3 < left < 0.5
    assert 0.55 < low < 0.8
    red = share.replace("TEST", "(data[at] > 150 && data[at + 1] < 60)")
    assert (await screen.look(red))[0] == 0
    goal = goal_in("active", (3.0, 3.0), goal_id="1", action="/drive", owner="drive")
    executive.detail(goals_sent=1, goals=(goal,))
    await screen.until(f"{red}[0] > 10")
    _, left, low = await screen.look(red)
    assert left > 0.5 > low


@scene_on_page()
async def test_a_halted_node_is_told_once(screen: Screen, executive: ScriptedExecutive) -> None:
    """It is not running, which is no claim that it never was."""
    executive.change(0.5, drive="running")
    await screen.shows("node", "drive")
    executive.change(1.0, drive="invalid: halted")
    await screen.shows("node", "not running")
    await screen.shows("node", "halted at")
    ended = await screen.look("[...document.querySelectorAll('#node dd')].pop().textContent")
    assert ended.count("halted") == 1


@scene_on_page()
async def test_the_camera_is_heard_while_its_panel_is_open(
    screen: Screen, executive: ScriptedExecutive
) -> None:
    """Its newest picture is painted."""
    await screen.click("camera-toggle")
    await screen.shows("camera-title", "waiting for a picture")
    red = messages.CameraImage(8, 6, 24, "rgb8", bytes([250, 0, 0]) * 48)
    wait = "document.getElementById('camera-title').textContent === 'Camera'"
    while not await screen.look(wait):
        executive.image = red if executive.has_camera else None
    pixel = await screen.look(
        "[...document.getElementById('camera').getContext('2d').getImageData(4, 3, 1, 1).data]"
    )
    assert pixel[0] > 200
    assert pixel[1] < 50
    assert executive.has_camera
    await screen.click("camera-toggle")
    await screen.until("document.getElementById('camera').hidden")


@pytest.mark.process(always=True)
@scene_on_page()
async def test_no_text_is_ever_markup(screen: Screen, executive: ScriptedExecutive) -> None:
    """Of a tree, a message, a goal, a variable, a requirement, a reason, an answer or the log."""
    executive.outline = f"{HOSTILE}\n  {HOSTILE}\n"
    executive.details = {"0": (HOSTILE,)}
    executive.begin("hostile")
    executive.stand("paused", HOSTILE)
    goal = goal_in(HOSTILE, goal_id=HOSTILE, action=HOSTILE, owner=HOSTILE)
    executive.detail(goals_sent=1, goals=(goal,), variables=((HOSTILE, f'"{HOSTILE}"'),))
    executive.say(HOSTILE)
    executive.answer(HOSTILE)
    executive.change(1.0, **{HOSTILE: f"running: {HOSTILE}"})
    executive.judge(**{HOSTILE: "violated -0.1"})
    await screen.until("document.querySelectorAll('.row').length === 2")
    await screen.look("document.getElementById('node-0').click()")
    for name in ("rows", "node", "goals", "variables", "log", "reason", "notice", "requirements"):
        await screen.shows(name, "<img src=x")
    await screen.look("document.querySelector('#variables button').click()")
    await screen.shows("chart-title", "<img src=x")
    assert await screen.look("document.querySelectorAll('img').length") == 0
    assert await screen.look("document.querySelectorAll('body script').length") == 0
    assert "owned" not in await screen.look("document.title.replace(/<.*>/g, '')")


@scene_on_page(width=390)
async def test_where_there_is_no_room_the_map_is_closed_and_the_tree_comes_before_the_buttons(
    screen: Screen, executive: ScriptedExecutive
) -> None:
    """On a phone; the buttons keep their names for screen readers."""
    top = "document.getElementById({!r}).getBoundingClientRect().top"
    assert await screen.look(f"{top.format('tree')} < {top.format('pause')}")
    assert await screen.look("document.getElementById('pause').textContent") == "Pause"
    assert await screen.look("document.getElementById('map').hidden")
    executive.show((messages.FrameTransform("map", "base_link", 1.5, 0.25, 0.0),))
    await screen.click("map-toggle")
    await screen.shows("map-title", "Map: x 1.50  y 0.25 m")
