"""A session for views, around an executive that a test ticks by hand."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from bt_mission.executive.events.events import LogLine
from bt_mission.executive.executive import Executive
from bt_mission.sessions.session import MissionRun, Session
from bt_mission.sessions.view import View


class _PlayedRun(MissionRun):
    def __init__(self, executive: Executive, mission: Any) -> None:
        super().__init__()
        self.runner: Any = SimpleNamespace(executive=executive, mission=mission)


class PlayedSession(Session):
    """One mission, whose clock stands where the test has set it."""

    start_ns = 0
    now_ns = 0

    def __init__(
        self,
        executive: Executive,
        *,
        now_ns: int = 2_000_000_000,
        world: str | None = None,
        **mission: Any,
    ) -> None:
        super().__init__()
        about = {"name": "test", "world": "hall", "robot": "waffle", "seed": 0, **mission}
        self.runs = (_PlayedRun(executive, SimpleNamespace(**about)),)
        self.world = world
        self.now_ns = now_ns

    def say(self, view: View, text: str) -> None:
        """Have the mission say a line."""
        view.on_event(self.runs[0], LogLine(self.now_ns, text, is_own=True))
