"""The times for which a user of the editor waits, in a headless Chromium.

1. An act in the tree of a mission of 1,000 nodes: from the key to the frame with the drawing after
   it, and to the text with the change. Budget of the first: below 100 ms.
2. From a key in a mission of 300 lines to the mark of its error. Budget: below 400 ms, of which the
   page waits 250 ms for further keys.
3. From *Run* to the first frame of the run's page. Budget: below 1.5 s.
4. The page's own files, compressed. Budget: below 1 MB.

Processor times are those of the page's main thread, and of this process, which is the server.

Run it as: python benchmarks/commands/edit/editing.py [--rounds N]
"""

from __future__ import annotations

import asyncio
import gzip
import os
import tempfile
import time
from functools import partial
from pathlib import Path

from benchmarks.measuring import arguments, figure, figures, spread
from bt_mission.base.dds.middleware import prepare_middleware
from bt_mission.commands.edit.vocabulary import kinds
from bt_mission.commands.edit.web.server import EditServer
from bt_mission.commands.edit.web.workspace import Workspace
from bt_mission.views.web.server import WebOptions, page_files
from tests.support.browser import BROWSER, Page, browser
from tests.support.web_pages import play_with
from tests.support.web_screen import Screen

NODES = 1_000
LINES = 300
LEAVES = 8
"""Leaves of each sequence of a mission."""

SETTLE_S = 1.0
"""Wall time between two acts: the text is checked in between."""

RUNS = 5
LONGEST_S = 3600.0

LAP = """
window.byId = (name) => document.getElementById(name);
window.painted = 0;
new MutationObserver(() => { window.painted++; })
  .observe(byId('picture'), { subtree: true, childList: true, attributes: true });
window.lap = (act, isOver) => new Promise((done) => {
  const begun = performance.now();
  const look = () => {
    if (!isOver()) { requestAnimationFrame(look); return; }
    const channel = new MessageChannel();
    channel.port1.onmessage = () => done(performance.now() - begun);
    channel.port2.postMessage(0);
  };
  act();
  look();
});
window.press = (key) => document.getElementById('drawing')
  .dispatchEvent(new KeyboardEvent('keydown', { key, bubbles: true }));
window.text = document.getElementById('text').shadowRoot;
window.write = (text) => {
  window.text.querySelector('.cm-content').focus();
  document.execCommand('insertText', false, text);
};
window.shown = () => document.getElementById('run-frame').contentDocument;
"""
"""Measures from an act to the end of the frame that shows its result."""

IDLE = "document.getElementById('drawing').getAttribute('aria-busy') !== 'true'"
MARKED = "window.text.querySelector('.cm-lintRange-error') !== null"
STARTED = (
    "window.shown()?.documentElement?.dataset.drawn > 0"
    " && window.shown().querySelectorAll('.row').length > 1"
)


def mission(nodes: int) -> str:
    """Return a mission of about this many nodes, with names and comments."""
    lines = ["mission: large", "world: dqn_stage4", "tree:", "  sequence:"]
    for group in range(nodes // (LEAVES + 2)):
        lines += [
            f"    - repeat: {{count: 2}}  # group {group}",
            f"      name: group {group}",
            "      do:",
        ]
        lines.append("        sequence:")
        for leaf in range(LEAVES // 2):
            lines += [f"          - log: at {group} {leaf}", "          - turn: {angle: 90}"]
            lines += [f"            name: turn {group} {leaf}", "            timeout: 30"]
    return "\n".join(lines) + "\n"


class Bench(Screen):
    """The page of the editor, with the times of what a user does."""

    async def open(self, link: str, name: str) -> None:
        """Open a file of a mission."""
        await self.visit(f"{link}?{name}#{name}", 1440, 900)
        await self.until("document.querySelectorAll('.node').length > 5")
        await self.until("document.getElementById('problems').textContent === 'no problems'")
        await self.look(LAP)

    async def lap(self, act: str, is_over: str) -> float:
        """Return the milliseconds from an act to a frame in which it is over."""
        script = f"window.lap(() => {{ {act} }}, () => {is_over})"
        evaluate = partial(self.page.call, "Runtime.evaluate", awaitPromise=True)
        answer = await asyncio.to_thread(partial(evaluate, expression=script))
        return float(answer["result"]["value"])

    async def worked_ms(self) -> float:
        """Return the processor time of the main thread of the page so far."""
        answer = await asyncio.to_thread(self.page.call, "Performance.getMetrics")
        facts = {metric["name"]: metric["value"] for metric in answer["metrics"]}
        return 1e3 * float(facts["ThreadTime"])


def show(name: str, times: list[float], *more: str) -> None:
    """Print a figure with its spread, and the load of the machine."""
    print("; ".join([f"{name}: {spread(figure(name, times, 'ms'), 'ms')}", *more]))
    print(f"  load of the machine: {os.getloadavg()[0]:.1f}", flush=True)


async def acts(bench: Bench, link: str, rounds: int) -> None:
    """Copy and delete a node, in turns."""
    await bench.open(link, "large.yaml")
    await bench.look("document.getElementById('drawing').focus()")
    for _ in range(5):
        await bench.look("window.press('ArrowDown')")
    rows: dict[str, list[tuple[float, ...]]] = {"c": [], "Delete": []}
    for key in [*rows] * rounds:
        await asyncio.sleep(SETTLE_S)  # noqa: TID251 - a benchmark of the wall
        before = await bench.look("window.painted")
        worked, used = await bench.worked_ms(), time.process_time()
        drawn = await bench.lap(f"window.press('{key}')", f"window.painted > {before}")
        after = await bench.lap("", IDLE)
        server = 1e3 * (time.process_time() - used)
        rows[key].append((drawn, drawn + after, await bench.worked_ms() - worked, server))
    for key, name in (("c", "a copy of a node"), ("Delete", "the deletion of a node")):
        drawn_ms, text_ms, page_ms, server_ms = (
            list(column) for column in zip(*rows[key], strict=True)
        )
        show(
            f"{name} to its redraw",
            drawn_ms,
            f"to its text {spread(text_ms, 'ms')}",
            f"processor time of the page {spread(page_ms, 'ms')}",
            f"of this process {spread(server_ms, 'ms')}",
        )


async def keys(bench: Bench, link: str, rounds: int) -> None:
    """Write an error, and undo it."""
    await bench.open(link, "usual.yaml")
    times = []
    for _ in range(rounds):
        times.append(await bench.lap("window.write('colour: red\\n')", MARKED))
        await bench.lap("document.getElementById('undo').click()", f"!({MARKED})")
        await asyncio.sleep(SETTLE_S)  # noqa: TID251 - a benchmark of the wall
    show("a key to its marked error", times)


async def runs(bench: Bench, rounds: int) -> None:
    """Run the mission again and again; a process gets ready in between."""
    times = []
    for _ in range(rounds):
        await asyncio.sleep(8 * SETTLE_S)  # noqa: TID251 - a benchmark of the wall
        times.append(await bench.lap("document.getElementById('run').click()", STARTED))
        await bench.lap("document.getElementById('run-stop').click()", "true")
    show("run to its first frame", times)


def measure(page: Page, missions: Path, rounds: int) -> None:
    """Serve the editor of a folder, and measure."""
    page.call("Performance.enable")

    async def scene(server: EditServer) -> None:
        bench = Bench(page)
        await acts(bench, server.link, rounds)
        await keys(bench, server.link, rounds)
        await runs(bench, min(rounds, RUNS))

    server = EditServer(Workspace(missions), WebOptions(port=0), keeps_ready=True)
    play_with(server, scene, LONGEST_S)


def main() -> None:
    """Measure, and print."""
    given = arguments(__doc__, rounds=11, nodes=NODES)
    if BROWSER is None:
        print("Chromium is not installed: nothing is measured")
        return
    size = sum(len(gzip.compress(content)) for content in page_files().values()) / 1e3
    figures("files", {"the page's files, compressed": (size, "kB")})
    prepare_middleware()
    kinds()
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as temporary:
        missions = Path(temporary) / "missions"
        missions.mkdir()
        (missions / "large.yaml").write_text(mission(given.nodes))
        (missions / "usual.yaml").write_text(mission(LINES // 2))
        with browser(Path(temporary) / "profile") as page:
            measure(page, missions, given.rounds)


if __name__ == "__main__":
    main()
