"""What the log of a recording says of a run."""

from __future__ import annotations

import json
from typing import Any

from rcl_interfaces.msg import Log

from bt_mission.recording.contents import log_line


def said(event: str, **fields: Any) -> tuple[int, str] | None:
    """The line for an event of the trace."""
    return log_line(json.dumps({"t": 1, "event": event, **fields}))


def test_what_happens_between_two_ticks_is_said() -> None:
    """Pauses, and what was done to the clock."""
    warn, info = Log.WARN[0], Log.INFO[0]
    assert said("paused", reason="by hand", keep_goals=False) == (warn, "paused: by hand")
    assert said("resumed") == (info, "resumed")
    assert said("clock", jump=-9.5) == (warn, "the ROS clock was set back by 9.5 s")
    assert said("clock", jump=100.0) == (warn, "the ROS clock skipped 100 s")
