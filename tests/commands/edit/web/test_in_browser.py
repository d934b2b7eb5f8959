"""The editor in a browser, by real keys and clicks."""

from __future__ import annotations

import asyncio
import json
import re
from collections.abc import Awaitable, Callable
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from bt_mission.base.yaml.document import read_text
from bt_mission.commands.edit.web.server import EditServer
from bt_mission.commands.edit.web.workspace import Workspace
from bt_mission.scenarios.loader import load_scenario
from bt_mission.views.web.server import WebOptions
from tests.support.browser import IN_BROWSER, Page
from tests.support.project import ROOT
from tests.support.web_pages import play_with
from tests.support.web_scenes import played
from tests.support.web_screen import Screen

pytestmark = IN_BROWSER

WORLD = (ROOT / "worlds" / "nav_arena.yaml").read_text()
README = re.findall(
    r"```yaml\n(mission: explore.*?)```", (ROOT / "README.md").read_text(), re.DOTALL
)[0]

DRAWN = """\
mission: explore
world: dqn_stage4
seed: 7
inputs:
  speed: 0.2
  legs: 6
tree:
  sequence:
    - camera_sweep: {sweep_angle: 180, image_count: 8}
      name: look around
      timeout: 60
      cancel_when: current_image >= 5
      on_cancel: success
    - repeat: {count: $legs}
      do:
        sequence:
          - explore_forward: {fwd_velocity: $speed, stopping_distance: 0.5}
            name: drive
            timeout: 30
            cancel_when: current_distance_travelled > 2.0
            on_cancel: success
            outputs: {closest_obstacle_angle: obstacle}
          - fallback:
              - turn: {angle: 'copysign(uniform(60, 120), -obstacle)'}
                name: turn away
                timeout: 30
              - log: no room to turn on
"""
TWO_DRIVES = """\
mission: two drives
world: dqn_stage4
tree:
  parallel:
    - {turn: {angle: 90}, timeout: 30}
    - {move: {secs: 1}, timeout: 30}
"""
TEXT = "document.getElementById('text').shadowRoot"
IDLE = "document.getElementById('drawing').getAttribute('aria-busy') !== 'true'"
CODES = {
    "Enter": (13, "\r"),
    "Delete": (46, ""),
    "F6": (117, ""),
    "ArrowDown": (40, ""),
    "ArrowUp": (38, ""),
}


class Editor(Screen):
    """The page of the editor: keys, clicks, and the text as it is on disk after a save."""

    def __init__(self, page: Page, file: Path) -> None:
        super().__init__(page)
        self.file = file

    async def call(self, method: str, **parameters: Any) -> None:
        """Call the browser, while the server serves."""
        await asyncio.to_thread(partial(self.page.call, method, **parameters))

    async def type(self, text: str) -> None:
        """Write into what has the focus."""
        await self.call("Input.insertText", text=text)

    async def press(self, key: str, *, ctrl: bool = False) -> None:
        """Press a key."""
        code, text = CODES.get(key, (ord(key[0].upper()), "" if ctrl or len(key) > 1 else key))
        facts: dict[str, Any] = {"key": key, "windowsVirtualKeyCode": code}
        facts["modifiers"] = 2 if ctrl else 0
        await self.call("Input.dispatchKeyEvent", type="keyDown", text=text, **facts)
        await self.call("Input.dispatchKeyEvent", type="keyUp", **facts)

    async def value(self, promise: str) -> Any:
        """Return what a promise of JavaScript gives."""
        call = partial(
            self.page.call,
            "Runtime.evaluate",
            expression=promise,
            awaitPromise=True,
            returnByValue=True,
        )
        return (await asyncio.to_thread(call))["result"]["value"]

    async def add(self, kind: str) -> None:
        """Add a node by the keys of the tree."""
        await self.look("document.getElementById('drawing').focus()")
        await self.press("a")
        await self.type(kind)
        await self.press("Enter")
        await self.until(IDLE)

    async def set(self, name: str, value: str) -> None:
        """Give a field of the form a value."""
        field = f"document.getElementById('form').elements[{name!r}]"
        await self.until(f"{field} !== undefined")
        await self.look(f"{field}.focus(), {field}.select?.()")
        if await self.look(f"{field}.tagName") == "SELECT":
            await self.look(
                f"{field}.value = {value!r}, {field}.dispatchEvent(new Event('change'))"
            )
        else:
            await self.type(value)
            await self.press("Enter")
        await self.until(IDLE)

    async def saved(self) -> str:
        """Save by Ctrl+S and the button of the difference; return the file."""
        await self.press("s", ctrl=True)
        await self.until("document.getElementById('window').open")
        await self.look("document.querySelector('#window-buttons button').click()")
        await self.until("document.getElementById('unsaved').hidden")
        await self.until(IDLE)
        assert not await self.look("document.getElementById('window').open"), "asked twice"
        return self.file.read_text()

    async def middle(self, name: str) -> tuple[float, float, float]:
        """Return the middle of the box of a name on the screen, and its height."""
        where = await self.look(
            "JSON.stringify([...document.querySelectorAll('.node')].find((one) => one.getAttribute("
            f"'aria-label').startsWith({name!r})).querySelector('.box').getBoundingClientRect())"
        )
        box = json.loads(where)
        return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2, box["height"]

    async def drag(self, name: str, onto: str, share: float) -> None:
        """Drag a box to a part of the height of another one."""
        x, y, _ = await self.middle(name)
        to_x, to_y, height = await self.middle(onto)
        mouse = partial(self.call, "Input.dispatchMouseEvent", button="left", clickCount=1)
        await mouse(type="mousePressed", x=x, y=y)
        for step in (0.5, 1.0):
            over = to_y + (share - 0.5) * height
            await mouse(type="mouseMoved", x=x + (to_x - x) * step, y=y + (over - y) * step)
        await mouse(type="mouseReleased", x=to_x, y=to_y + (share - 0.5) * height)
        await self.until(IDLE)


@pytest.fixture
def play(chromium: Page, tmp_path: Path) -> Callable[..., None]:
    """Play a scene on the editor of a file or its folder; nothing may go wrong on the page."""

    def play(
        scene: Callable[[Editor], Awaitable[None]], *, text: str | None = None, folder: bool = False
    ) -> None:
        file = tmp_path / "explore.yaml"
        if text is not None:
            file.write_text(text)
        editor = Editor(chromium, file)

        async def visited(server: EditServer) -> None:
            await editor.visit(server.link, 1440, 900)
            try:
                await scene(editor)
            finally:
                await editor.look("onbeforeunload = null, document.body.remove()")

        workspace = Workspace(tmp_path if folder else file)
        play_with(EditServer(workspace, WebOptions(port=0)), visited)
        assert chromium.problems == []

    return play


@pytest.mark.thorough
@played("play")
async def test_the_mission_of_the_readme_by_graphical_acts(editor: Editor) -> None:
    """From an empty file, by the tree and the form: the text is as a person writes it."""
    await editor.add("sequence")
    await editor.add("camera_sweep")
    await editor.set("camera_sweep.image_count", "8")
    await editor.set("name", "look around")
    await editor.set("cancel_when", "current_image >= 5")
    await editor.set("on_cancel", "success")
    await editor.add("repeat")
    await editor.set("repeat.count", "$legs")
    await editor.add("sequence")
    await editor.add("explore_forward")
    await editor.set("explore_forward.fwd_velocity", "$speed")
    await editor.set("name", "drive")
    await editor.set("timeout", "30")
    await editor.set("cancel_when", "current_distance_travelled > 2.0")
    await editor.set("on_cancel", "success")
    await editor.set("outputs name", "closest_obstacle_angle")
    await editor.set("outputs value", "obstacle")
    await editor.add("fallback")
    await editor.add("turn")
    await editor.set("turn.angle", "copysign(uniform(60, 120), -obstacle)")
    await editor.set("name", "turn away")
    await editor.set("timeout", "30")
    await editor.add("log")
    await editor.set("log", "no room to turn on")
    await editor.look("document.getElementById('drawing').focus()")
    await editor.press("Home")
    await editor.set("mission", "explore")
    await editor.set("world", "dqn_stage4")
    await editor.set("seed", "7")
    for name, value in (("speed", "0.2"), ("legs", "6")):
        await editor.set("inputs name", name)
        await editor.set("inputs value", value)
    assert await editor.saved() == DRAWN
    await editor.shows("problems", "no problems")
    await editor.look("document.getElementById('drawing').focus()")
    await editor.press("0")
    for _ in range(4):  # all boxes are in view, smaller than is readable
        await editor.press("-")
    await editor.drag("turn away", "look around", 0.9)
    await editor.until("document.getElementById('box-3').textContent.includes('turn away')")
    await editor.drag("turn away", "log", 0.1)
    await editor.until("document.getElementById('unsaved').hidden")
    await editor.drag("drive", "sequence", 0.5)
    await editor.press("Delete")
    await editor.until(IDLE)
    await editor.press("z", ctrl=True)
    await editor.press("z", ctrl=True)
    await editor.until("document.getElementById('unsaved').hidden")
    assert read_text(DRAWN).data == read_text(README).data


@played("play")
async def test_the_mission_of_the_readme_as_text(editor: Editor) -> None:
    """The drawing follows; a mistake is marked in text and tree, and a completion corrects it."""
    before, _, behind = README.partition("dqn_stage4")
    await editor.press("F6")
    await editor.type(f"{before}dqn_stag")
    await editor.type("e")
    await editor.until(f"{TEXT}.querySelectorAll('.cm-completionLabel').length === 4")
    await editor.until("(window.begun ??= Date.now()) + 150 < Date.now()")  # its delay for keys
    for _ in range(3):
        await editor.press("ArrowDown")
    await editor.until(f"{TEXT}.querySelector('[aria-selected]')?.innerText[9] === '4'")
    await editor.press("Enter")
    await editor.type(behind)
    await editor.until("document.querySelectorAll('.node').length === 9")
    await editor.shows("problems", "no problems")
    for key in ("ArrowUp", "ArrowDown"):  # what follows is a change of its own for undo
        await editor.press(key)
    await editor.type("colour: red\n")
    await editor.shows("problems", "1 error")
    await editor.until("document.querySelector('#box-0.has-error') !== null")
    await editor.press("z", ctrl=True)
    await editor.shows("problems", "no problems")
    assert await editor.saved() == README


@pytest.mark.process(always=True)
@played("play")
async def test_hostile_names_are_text(editor: Editor) -> None:
    """Markup in a name is shown as it is written."""
    await editor.add("wait")
    await editor.set("name", "<img src=x onerror=alert(1)>")
    await editor.until(
        "document.querySelector('#box-1 text:nth-of-type(2)').textContent[0] === '<'"
    )
    assert await editor.look("document.querySelectorAll('img').length") == 0
    assert "name: <img src=x onerror=alert(1)>" in await editor.saved()


@played("play")
async def test_characters_that_cannot_be_seen_are_marked(editor: Editor) -> None:
    """As everywhere, what is shown is what is read; the reader refuses them in a comment."""
    await editor.press("F6")
    await editor.type("# \u202e \u200c \u2060 \u2029 \u3164 \U000e0101 \u00e9 \U0001f600")
    await editor.until(f"{TEXT}.querySelectorAll('.cm-specialChar').length === 6")
    await editor.shows("problems", "error")


@pytest.mark.thorough
@played("play")
async def test_the_findings_of_a_proof_are_at_their_nodes(editor: Editor) -> None:
    """One that is opened by its key selects a node, and shows the steps."""
    await editor.press("F6")
    await editor.type(TWO_DRIVES)
    await editor.until("document.querySelectorAll('.node').length === 4")
    await editor.click("prove")
    await editor.shows("proof-title", "1 finding")
    ids = "[...document.querySelectorAll('.node:has(.badge)')].map((one) => one.id).join()"
    await editor.until(f"{ids} === 'box-2,box-3'")
    await editor.look("document.querySelector('#proof summary').focus()")
    await editor.press("Enter")
    await editor.until("document.querySelector('#box-2[aria-selected=true]') !== null")
    steps = await editor.look("document.querySelector('#proof ol').innerText")
    assert steps.split("\n") == ["/turn accepts the goal", "/move accepts the goal"]
    await editor.look("document.querySelectorAll('#proof .findings button')[1].click()")
    await editor.until("document.querySelector('#box-3[aria-selected=true]') !== null")
    await editor.press("F6")
    await editor.type("# ")
    await editor.until("document.querySelector('.badge') === null")
    await editor.click("close-proof")
    await editor.until("document.getElementById('proof').hidden")


@pytest.mark.thorough
@played("play")
async def test_a_run_of_the_text_is_shown_beside_it(editor: Editor, monkeypatch: Any) -> None:
    """Also of unsaved text; the drawing shows statuses, and a change is applied to the run."""
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    await editor.add("sequence")
    await editor.add("wait")
    await editor.set("wait", "600")
    await editor.look("document.getElementById('editable').checked = true")
    await editor.click("run")
    await editor.until("document.querySelectorAll('.ran-running').length === 2")
    frame = "document.getElementById('run-frame').contentDocument"
    await editor.until(f"{frame}.getElementById('status').textContent === 'running'")
    await editor.add("log")
    await editor.click("apply")
    await editor.shows("window-body", "+ log")
    await editor.look("document.querySelector('#window-buttons button').click()")
    await editor.until(f"{frame}.querySelectorAll('.row').length === 3")
    await editor.click("run-stop")
    await editor.until("document.getElementById('run-panel').hidden")
    await editor.until("document.querySelectorAll('.ran-running').length === 0")
    assert not editor.file.exists()


@pytest.mark.thorough
@played("play")
async def test_a_run_pauses_at_a_node_and_continues_with_another_text(editor: Editor) -> None:
    """The window shows what changed. Obstacles from the map are in both runs, and in a scenario."""
    await editor.press("F6")
    await editor.type("mission: m\ntree:\n  sequence:\n    - wait: 600\n    - log: here\n")
    await editor.until("document.querySelectorAll('.node').length === 4")
    frame = "document.getElementById('run-frame').contentDocument"
    await editor.saved()
    await editor.look("document.getElementById('drawing').focus()")
    for _ in range(2):
        await editor.press("ArrowRight")
    await editor.press("m")
    await editor.until("document.querySelectorAll('#plan .shape').length === 4")
    for _ in range(8):
        await editor.press("ArrowUp")
    await editor.press("Enter")  # takes the place, and goes to the button
    await editor.press("Enter")
    await editor.shows("things", "at 0.0: spawn_box at (0, 0.8)")
    await editor.press("m")
    await editor.press("r")
    await editor.until(f"{frame}?.getElementById('status')?.textContent === 'paused'")
    await editor.until(f"{frame}.querySelector('[aria-label*=breakpoint]') !== null")
    await editor.shows("run-state", "paused: breakpoint at 'wait'")
    await editor.until("document.querySelector('#box-2[aria-label*=breakpoint]') !== null")
    await editor.set("wait", "0.5")
    await editor.click("show-map")
    await editor.until("document.activeElement.id === 'plan'")
    floor = "document.querySelector('#plan .floor').getBoundingClientRect()"
    box = json.loads(await editor.look(f"JSON.stringify({floor})"))
    at = {"x": box["x"] + 0.7 * box["width"], "y": box["y"] + 0.3 * box["height"]}
    for kind in ("mousePressed", "mouseReleased"):
        await editor.call("Input.dispatchMouseEvent", type=kind, button="left", clickCount=1, **at)
    await editor.press("Enter")
    await editor.shows("things", "at 0.05: spawn_box at (0.8, 0.8)")
    await editor.click("show-map")
    await editor.look("document.getElementById('drawing').focus()")
    await editor.press("R")
    await editor.shows("window-title", "Continue from 0.05 s")
    await editor.shows("window-body", "+    - wait: 0.5")
    await editor.shows("window-body", "+ fault at 0.05: spawn_box at (0.8, 0.8)")
    await editor.look("document.querySelector('#window-buttons button').click()")
    await editor.until(f"{frame}?.getElementById('status')?.textContent === 'success'")
    await editor.shows("run-state", "from 0.05 s with the text as it is")
    await editor.until(f"{frame}.getElementById('log').textContent.includes('fault 2 begins')")
    await editor.saved()
    await editor.look("document.getElementById('save-scenario').click()")
    await editor.shows("window-body", "outcome: any")
    await editor.look("document.querySelector('#window-buttons button').click()")
    await editor.shows("banners", "Written: explore_faults.yaml")
    path = editor.file.with_name("explore_faults.yaml")
    scenario = load_scenario(path)
    texts = [fault.text for fault in scenario.faults]
    assert texts == ["at 0.0: spawn_box at (0, 0.8)", "at 0.05: spawn_box at (0.8, 0.8)"]


@played("play", text=WORLD)
async def test_a_world_is_drawn_on_its_map(editor: Editor) -> None:
    """By keys, the mouse and the form: only the lines of what has changed are others."""
    shapes = "document.querySelectorAll('#plan .shape').length"
    fields = "document.getElementById('plan-form').elements"
    choose = "(tool.value = {!r}, tool.dispatchEvent(new Event('change')))"
    await editor.until(f"{shapes} === 12")
    await editor.look(f"(tool => {choose.format('walls')})(document.getElementById('tool'))")
    await editor.press("Enter")
    await editor.press("ArrowUp")
    await editor.press("Enter")
    await editor.until(f"{shapes} === 13")
    await editor.look(f"(tool => {choose.format('')})(document.getElementById('tool'))")
    zone, floor = [
        json.loads(
            await editor.look(
                f"JSON.stringify(document.querySelector({name!r}).getBoundingClientRect())"
            )
        )
        for name in ("#plan .zone", "#plan .floor")
    ]
    mouse = partial(editor.call, "Input.dispatchMouseEvent", button="left")
    at = {"x": zone["x"] + zone["width"] / 2, "y": zone["y"] + zone["height"] / 2}
    await mouse(type="mousePressed", clickCount=1, **at)
    at["x"] += floor["width"] / 10
    await mouse(type="mouseMoved", **at)
    await mouse(type="mouseReleased", clickCount=1, **at)
    await editor.until(f"{fields}.x?.value === '-1.35' && {IDLE}")
    await editor.look(f"{fields}.radius.focus(), {fields}.radius.select()")
    await editor.type("0.3")
    await editor.press("Enter")
    radius = "document.querySelector('#plan .zone').getAttribute('r')"
    await editor.until(f"{radius} === '0.3' && {IDLE}")
    await editor.look("document.querySelectorAll('#things button')[4].focus()")
    await editor.press("Enter")
    await editor.until(f"{fields}.name.value === 'wall beside A'")
    await editor.look("document.getElementById('plan').focus()")
    await editor.press("Delete")
    await editor.until(f"{shapes} === 12")
    lines = WORLD.splitlines()
    after = (await editor.saved()).splitlines()
    assert [line for line in after if line not in lines] == [
        "  - {name: wall 1, from: [0, 0], to: [0, 0.1]}",
        "  - {name: A, x: -1.35, y: -1.76, radius: 0.3, colour: green}",
    ]
    gone = [line.split(",")[0] for line in lines if line not in after]
    assert gone == ["  - {name: wall beside A", "  - {name: A"]


TWO_LINES = "mission: m\n# one\ntree:\n  sequence:\n    - wait: 1\n# end\n"


@played("play", text=TWO_LINES, folder=True)
async def test_what_is_not_shown_is_named_and_hinders_no_save(
    editor: Editor, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Files beyond the limits, and the differences of a long text."""
    await editor.until("document.getElementById('files').value === 'explore.yaml'")
    for name in ("z.yaml", "a\nb.yaml"):
        editor.file.with_name(name).write_text("mission: x\n")
    monkeypatch.setattr("bt_mission.commands.edit.web.workspace.MOST_FILES", 1)
    monkeypatch.setattr("bt_mission.commands.edit.web.server.MOST_LINES", 2)
    await editor.visit(await editor.look("location.href.split('#')[0]"), 1440, 900)
    await editor.shows("banners", "a\\nb.yaml")
    await editor.shows("banners", "Not all files are shown, but 1.")
    await editor.until("document.title.startsWith('explore.yaml')")
    await editor.look(f"{TEXT}.querySelector('.cm-content').focus()")
    await editor.type("# mine\n")
    await editor.press("s", ctrl=True)
    await editor.shows("window-body", "at most 2 lines")
    await editor.look("document.querySelector('#window-buttons button').click()")
    await editor.until("document.getElementById('unsaved').hidden")
    assert editor.file.read_text() == f"# mine\n{TWO_LINES}"
    await editor.shows("banners", "Not all files are shown, but 1.")


@played("play", text=TWO_LINES, folder=True)
async def test_what_was_typed_survives_another_file_and_another_page(editor: Editor) -> None:
    """Also what was typed a moment ago. A page that wakes up does not write over the other's."""
    folder = editor.file.parent
    (folder / "other.yaml").write_text(TWO_LINES)
    mine, second = f"# mine\n{TWO_LINES}", f"# second\n{TWO_LINES}"

    def drafts() -> set[str]:
        return {path.read_text() for path in folder.glob(".explore.yaml.*.unsaved")}

    async def opened(name: str) -> None:
        await editor.look(
            "((files) => { files.add(new Option('other.yaml')); "
            f"files.value = {name!r}; files.dispatchEvent(new Event('change')); }})"
            "(document.getElementById('files'))"
        )
        await editor.until(f"location.hash === '#{name}' && document.title.startsWith({name!r})")

    async def typed(text: str) -> None:
        await editor.look(f"{TEXT}.querySelector('.cm-content').focus()")
        await editor.type(text)

    async def click(banner: str, label: str) -> None:
        button = f"[...document.querySelectorAll('[id^=banner-{banner}] button')]"
        button += f".find((one) => one.textContent === {label!r})"
        await editor.until(f"{button} !== undefined")
        await editor.look(f"{button}.click()")

    await editor.until("document.getElementById('files').value === 'explore.yaml'")
    await typed("# mine\n")
    await opened("other.yaml")
    assert drafts() == {mine}
    await opened("explore.yaml")
    await typed("# second\n")
    await editor.until("!document.getElementById('unsaved').hidden")
    await opened("other.yaml")
    assert drafts() == {mine, second}
    await opened("explore.yaml")
    await click("draft", "Restore it")
    await click("draft", "Delete it")
    state = "fetch('api/state', {method: 'POST', body: JSON.stringify(%s)}).then((a) => a.json())"
    other = {"name": "explore.yaml", "page": "other", "text": "mission: other\n"}
    asleep = await editor.value(state % json.dumps(other))
    assert asleep["leads"] is False
    assert (await editor.value(state % json.dumps(other | {"take": True})))["leads"] is True
    await editor.until(f"{TEXT}.textContent.includes('mission: other')")
    assert drafts() == {second}
    await click("mine", "Take over with it")
    await editor.until(f"!{TEXT}.textContent.includes('mission: other')")
    assert await editor.saved() == second
    assert (folder / "other.yaml").read_text() == TWO_LINES
    assert drafts() == set()


@played("play", text=TWO_LINES, folder=True)
async def test_of_files_chosen_one_after_another_the_last_is_shown(editor: Editor) -> None:
    """One that cannot be opened leaves the file before it, and says why."""
    for name in ("first.yaml", "last.yaml"):
        (editor.file.parent / name).write_text(f"# {name}\n{TWO_LINES}")

    async def choose(*names: str) -> None:
        await editor.look(
            f"((files, names) => names.forEach((name) => {{ files.add(new Option(name)); "
            "files.value = name; files.dispatchEvent(new Event('change')); }))"
            f"(document.getElementById('files'), {list(names)})"
        )

    await editor.until("document.title.startsWith('explore.yaml')")
    await choose("first.yaml", "last.yaml")
    await editor.until("location.hash === '#last.yaml'")
    assert "# last.yaml" in await editor.look(f"{TEXT}.textContent")
    await choose("/outside.yaml")
    await editor.until("document.getElementById('files').value === 'last.yaml'")
    await editor.until("document.getElementById('banner-refusal').textContent.includes('outside')")


@played("play", text=TWO_LINES, folder=True)
async def test_files_of_a_folder_and_a_file_that_changed_on_disk(editor: Editor) -> None:
    """A file is created, renamed and deleted; of two versions each place can be chosen."""
    window = "document.getElementById('window')"

    async def click(label: str) -> None:
        buttons = "[...document.querySelectorAll('#window-buttons button')]"
        await editor.look(f"{buttons}.find((one) => one.textContent === {label!r}).click()")

    async def named(name: str, label: str) -> None:
        await editor.look("document.getElementById('file-acts').click()")
        await editor.look(f"document.getElementById('file-name').value = {name!r}")
        await click(label)
        await editor.until(f"document.getElementById('files').value === {name!r}")

    await editor.until("document.getElementById('files').value === 'explore.yaml'")
    await named("new.yaml", "Create")
    await named("newer.yaml", "Rename")
    await editor.look("document.getElementById('file-acts').click()")
    await click("Delete…")
    await editor.until(f"{window}.open")
    await click("Delete")
    await editor.until("document.getElementById('files').value === 'explore.yaml'")
    await editor.until("document.getElementById('files').options.length === 1")
    await editor.until("document.querySelectorAll('.node').length === 3")
    await editor.until("document.getElementById('problems').textContent === 'no problems'")
    await editor.add("log")
    mine = await editor.look(f"{TEXT}.textContent")
    assert "log" in mine
    editor.file.write_text(TWO_LINES.replace("# one", "# one on disk"))
    await editor.until("document.getElementById('banner-conflict') !== null")
    await editor.look("document.querySelector('#banner-conflict button').click()")
    await editor.until(f"{window}.open && document.querySelectorAll('fieldset').length > 1")
    await click("Use these lines")
    text = await editor.saved()
    assert "# one on disk\n" in text
    assert "log" in text
    assert [path.name for path in editor.file.parent.iterdir()] == ["explore.yaml"]
