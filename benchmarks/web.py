"""The time from a change to a browser's screen, and the cost of pages for the mission.

1. A tree of 10,000 nodes changes ten times a second, and a headless Chromium shows it: from the
   change to the frame that paints it. Budget: below 100 ms.
2. A mission on the stage, as fast as it goes: the process's CPU time without a page, and with one
   that has the map open. And in real time: the CPU time for a second of the wall.

Run it as: python benchmarks/web.py [--mission FILE] [--rounds N] [--changes N]
"""

from __future__ import annotations

import asyncio
import statistics
import tempfile
import time
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

from measuring import arguments, figure, figures

from bt_mission.base.interrupts import InterruptSignals
from bt_mission.scenarios.faults.world import MOST_OBSTACLES
from bt_mission.sessions.drive import Reports, StepDriver, drive, driving
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage
from bt_mission.sessions.stage_robot import StageOptions
from bt_mission.sessions.watching import SessionGraph
from bt_mission.views.terminal.log_lines import LogLineView
from bt_mission.views.web.live import LiveMission
from bt_mission.views.web.server import FAST_FRAME_S, FRAME_S, WebOptions, WebServer
from tests.support.browser import BROWSER, browser
from tests.support.watched import ScriptedExecutive, ScriptedGraph
from tests.support.web_pages import play_with

NODES = 10_000
EVERY_S = 0.1
LONGEST_S = 3600.0
LEGS = 60
"""Of the mission at full speed: the cost of opening a page should not count for much."""

WATCH_PAINTS = """
window.paints = {};
new MutationObserver(() => {
  const words = document.querySelector('.row[aria-selected=true] .words')?.textContent;
  if (!words || words in window.paints) return;
  const channel = new MessageChannel();
  window.paints[words] = null;
  channel.port1.onmessage = () => {
    window.paints[words] = performance.timeOrigin + performance.now();
  };
  channel.port2.postMessage(0);
}).observe(document.getElementById('rows'), { subtree: true, childList: true, attributes: true });
"""
"""Notes when the frame with each text was painted: the message to itself follows directly."""


def latencies(changes: int) -> list[float]:
    """Return the milliseconds from each change to its paint."""
    executive = ScriptedExecutive("root\n" + "".join(f"  leaf {index}\n" for index in range(NODES)))
    executive.begin()
    shown = LiveMission(ScriptedGraph(executive))
    made_ms: dict[str, float] = {}
    seen_ms: dict[str, float] = {}

    async def scene(server: WebServer) -> None:
        await asyncio.to_thread(lambda: page.visit(server.link, width=1200, height=800))
        await asyncio.to_thread(page.until, "document.querySelectorAll('.row').length > 10")
        await asyncio.to_thread(page.look, WATCH_PAINTS)
        for number in range(changes):
            words = f"change {number}"
            made_ms[words] = time.time() * 1e3  # noqa: TID251 - beside the browser's clock
            # Leaves all over the tree, so that the page has to scroll each time.
            leaf = f"leaf_{number * 997 % NODES}"
            executive.change(EVERY_S, **{leaf: f"running: {words}"})
            await asyncio.sleep(EVERY_S)  # noqa: TID251 - a benchmark of the wall
            executive.change(0.0, **{leaf: "success"})
        seen_ms.update(await asyncio.to_thread(page.look, "window.paints"))

    with (
        tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder,
        browser(Path(folder)) as page,
    ):
        play_with(WebServer(shown, WebOptions(port=0)), scene, LONGEST_S)
    return [seen_ms[words] - at_ms for words, at_ms in made_ms.items() if seen_ms.get(words)]


def cpu_share(mission_file: Path, *, with_page: bool, speed: float | None) -> tuple[float, float]:
    """Return the CPU seconds of the process for a virtual second, and for a wall second."""
    legs = {"legs": LEGS if speed is None else 6}
    mission = load(mission_file, legs if "legs" in load(mission_file).inputs else {})
    options = StageOptions(props=MOST_OBSTACLES if with_page else 0)  # as `run --web` sets it
    with (
        tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder,
        Stage(mission, image_folder=Path(folder), say=lambda _: None, options=options) as stage,
    ):
        if with_page:
            (report,), cpu_s = _shown(stage, Path(folder), speed)
        else:
            (report,), cpu_s = _measured(lambda: drive(stage, [LogLineView()], speed=speed))
    return cpu_s / report.virtual_s, cpu_s / report.wall_s


def _measured(run: Callable[[], Reports]) -> tuple[Reports, float]:
    """Return the reports of a run, and the CPU seconds of the process for it."""
    before_s = time.process_time()
    reports = run()
    return reports, time.process_time() - before_s


def _shown(stage: Stage, folder: Path, speed: float | None) -> tuple[Reports, float]:
    driver = StepDriver(driving(stage, [LogLineView()], InterruptSignals(), speed=speed))
    frame_s = FAST_FRAME_S if speed is None else FRAME_S
    with closing(SessionGraph(stage)) as graph:
        shown = LiveMission(graph)
        shown.attach(graph.name)
        with (
            closing(WebServer(shown, WebOptions(port=0, frame_s=frame_s))) as server,
            browser(folder / "profile") as page,
        ):
            page.send("Page.navigate", url=server.link)  # opened once the server runs

            def run() -> Reports:
                asyncio.run(server.serve(lambda: driver.is_over, driver))
                return driver.finish()

            return _measured(run)


def main() -> None:
    """Measure, and print."""
    given = arguments(
        __doc__,
        mission=Path(__file__).with_name("explore_no_camera.yaml"),
        rounds=3,
        changes=200,
        brief=(False, "without the run in real time"),
    )
    if BROWSER is None:
        print("Chromium is not installed: nothing is measured")
        return
    times = sorted(latencies(given.changes))
    figures(
        f"{NODES} nodes, {1 / EVERY_S:.0f} changes a second", {"change to paint": (times, "ms")}
    )
    print(
        f"95 % below {times[int(0.95 * len(times))]:.0f} ms; {len(times)} of {given.changes} "
        "were painted\n"
    )
    paces: list[tuple[float | None, str]] = [(None, "as fast as it goes")]
    if not given.brief:
        paces.append((1.0, "in real time"))
    for speed, name in paces:
        ratios = []
        for _ in range(given.rounds if speed is None else 1):
            plain = cpu_share(given.mission, with_page=False, speed=speed)
            page = cpu_share(given.mission, with_page=True, speed=speed)
            ratios.append(page[0] / plain[0] - 1)
            print(
                f"{name}: {plain[0] * 1e3:.2f} ms of CPU for a virtual second without a page, "
                f"{page[0] * 1e3:.2f} ms with one ({ratios[-1]:+.1%}); for a second of the wall "
                f"{plain[1] * 1e3:.0f} and {page[1] * 1e3:.0f} ms; a virtual second took "
                f"{plain[0] / plain[1]:.3f} and {page[0] / page[1]:.3f} s"
            )
        print(f"{name}: median {statistics.median(ratios):+.1%}")
        figure(f"{name}: CPU with a page to without", [1 + ratio for ratio in ratios])


if __name__ == "__main__":
    main()
