"""What the log of a recording says of a run."""

from __future__ import annotations

import json
from typing import Any

from bt_mission.recording.contents import INFO, WARN, log_line


def said(event: str, **fields: Any) -> tuple[int, str] | None:
    """The line for an event of the trace."""
    return log_line(json.dumps({"t": 1, "event": event, **fields}))


def test_what_happens_between_two_ticks_is_said() -> None:
    """Pauses, and what was done to the clock."""
    assert said("paused", reason="by hand", keep_goals=False) == (WARN, "paused: by hand")
    assert said("resumed") == (INFO, "resumed")
    assert said("clock", jump=-9.5) == (WARN, "the ROS clock was set back by 9.5 s")
    assert said("clock", jump=100.0) == (WARN, "the ROS clock skipped 100 s")
