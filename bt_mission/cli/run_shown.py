"""Sessions shown on a full screen, or in browsers."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from contextlib import closing
from typing import TYPE_CHECKING, Protocol, TypeVar

from bt_mission.cli.extensions import shown_by
from bt_mission.cli.web import ENDED, page_stays, to_stderr, web_server

if TYPE_CHECKING:
    from bt_mission.base.interrupts import InterruptSignals
    from bt_mission.scenarios.faults.live import LiveFaults
    from bt_mission.sessions.drive import Reports, Steps
    from bt_mission.sessions.session import Session


class ShownReport(Protocol):
    """The report of a mission or of a fleet, as used here."""

    @property
    def verdict(self) -> str:
        """Its verdict."""


R = TypeVar("R")
Ended = TypeVar("Ended", bound=ShownReport)


def with_end(steps: Steps[Reports], end: Callable[[Reports], R]) -> Steps[R]:
    """Return the steps of a session with a result of its reports."""
    reports = yield from steps
    return end(reports)


def shown_on_screen(session: Session, steps: Steps[R], interrupts: InterruptSignals) -> R:
    """Run it on a full screen, which shows one mission at a time."""
    from bt_mission.sessions.watching import SessionGraph
    from bt_mission.views.terminal.marks import marks_for
    from bt_mission.views.tui.run_app import RunApp

    with closing(SessionGraph(session)) as graph:
        marks = marks_for(sys.stdout.encoding)
        app = RunApp(graph, marks, graph.name, steps, interrupts, session.watch)
        return app.run_to_the_end()


def shown_on_page(
    options: argparse.Namespace,
    session: Session,
    steps: Steps[Ended],
    interrupts: InterruptSignals,
    speed: float | None,
    until_ns: int = 0,
    live: LiveFaults | None = None,
) -> Ended:
    """Run a session shown to browsers, one mission at a time; its page stays until Ctrl-C.

    The page is served from `until_ns` on, an instant of ROS time, and shows what was before. A page
    that fails ends nothing: the mission continues without it.

    Args:
        live: Makes the faults that pages ask for.
    """
    import asyncio

    from bt_mission.sessions.drive import StepDriver
    from bt_mission.sessions.watching import SessionGraph
    from bt_mission.views.web.live import LiveMission, OpenPanels

    driver = StepDriver(steps)
    has_said = False

    def is_over() -> bool:
        nonlocal has_said
        if driver.result is None:
            return driver.error is not None
        if not (interrupts.count or has_said):
            has_said = True
            to_stderr(page_stays(driver.result.verdict))
        return interrupts.count > 0

    with closing(SessionGraph(session)) as graph:
        shown = LiveMission(
            graph,
            graph.name,
            lambda: ENDED if driver.result else "",
            is_fleet=len(session.runs) > 1,
            faults=live,
        )
        shown.attach(graph.name)  # before the first step, so that nothing is missed
        while session.now_ns < until_ns and not driver.is_over:
            driver.advance()
            shown.look(OpenPanels())
        if not driver.is_over:
            with web_server(options, shown, is_fast=(speed or 0.0) > 1.0) as server:
                try:
                    asyncio.run(server.serve(is_over, driver))
                except Exception as error:  # noqa: BLE001 - a view must not break the mission
                    what = f"{type(error).__name__}: {error}"
                    to_stderr(f"the page failed; the mission continues: {what}")
    return driver.finish()


def pace(options: argparse.Namespace) -> float | None:
    """Views show the run in real time, unless the options give another speed."""
    is_shown = options.tui or options.view or options.web or shown_by(options)
    return options.speed or (1.0 if is_shown and not options.attach else None)
