"""Take the picture of the editor beside a run, docs/images/edit.png, in a headless Chromium."""

from __future__ import annotations

import asyncio
from pathlib import Path

from bt_mission.base.dds.middleware import prepare_middleware
from bt_mission.commands.edit.web.server import EditServer
from bt_mission.commands.edit.web.workspace import Workspace
from bt_mission.views.web.server import WebOptions
from tests.support.browser import Page
from tests.support.web_pages import play_with
from tools.capture_page import LIMIT_S, ROOT, capture


def capture_edit(page: Page, folder: Path) -> None:
    """Capture the editor beside a run."""
    prepare_middleware()
    missions = folder / "missions"
    missions.mkdir()
    (missions / "explore.yaml").write_bytes((ROOT / "missions" / "explore.yaml").read_bytes())

    def look(link: str) -> None:
        page.visit(link, width=1440, height=820)
        page.until("document.querySelectorAll('.node').length > 5")
        page.look("document.getElementById('speed').value = '4'")
        page.look("document.getElementById('run').click()")
        frame = "document.getElementById('run-frame').contentDocument"
        page.until(f"{frame}.getElementById('log')?.children.length > 6", 60)
        page.screenshot(folder / "edit.png")

    editor = EditServer(Workspace(missions), WebOptions(port=0))
    play_with(editor, lambda server: asyncio.to_thread(look, server.link), LIMIT_S)


if __name__ == "__main__":
    capture("edit", capture_edit)
