"""Where the code of a program waits, and for what, for people."""

from __future__ import annotations

from pathlib import Path
from types import FrameType
from typing import Any

from bt_mission.base.clock_watch import Holder, callback_in
from bt_mission.base.code_owner import owner_of
from bt_mission.programs.calls import Call

_FUNCTIONS = {
    ("rclpy.client", "call"): "waits for the answer of {self.srv_name}",
    ("rclpy.client", "wait_for_service"): "waits for the service {self.srv_name}",
    ("rclpy.action.client", "send_goal"): "waits for the result of {self._action_name}",
    ("rclpy.action.client", "_cancel_goal"): "waits for the end of a goal of {self._action_name}",
    ("rclpy.action.client", "wait_for_server"): "waits for the server of {self._action_name}",
    ("rclpy.timer", "sleep"): "sleeps on a rate",
    ("threading", "wait"): "waits for an event or a condition",
    ("queue", "get"): "waits for an item of a queue",
    ("queue", "put"): "waits for room in a queue",
    ("concurrent.futures._base", "result"): "waits for the result of a thread",
    ("concurrent.futures.thread", "shutdown"): "waits for the end of threads",
}
"""Functions that wait, by module and name, and what that means."""


def frames_of(call: Call) -> list[FrameType]:
    """Return the frames of a call that waits, the innermost first."""
    frames = []
    frame: Any = call.gr_frame
    while frame is not None:
        frames.append(frame)
        frame = frame.f_back
    return frames


def holder_of(call: Call) -> Holder | None:
    """Return the callback of a call that waits, and its place."""
    holder = callback_in(call.gr_frame)
    if holder is not None:
        return holder
    for frame in frames_of(call):
        code = frame.f_code
        if owner_of(code.co_filename) == "user":
            name = getattr(code, "co_qualname", code.co_name).replace("<locals>.", "")
            return Holder(name, f"{Path(code.co_filename).name}:{frame.f_lineno}")
    return None


def what_of(call: Call) -> str:
    """Return who waits, where, and for what, such as ``Server.execute (fib.py:24) sleeps``."""
    return f"{holder_of(call) or call.program.name} {reason_of(call)}"


def reason_of(call: Call) -> str:
    """Return what a call waits for, as its outermost function of a library says."""
    reason = call.wait.what if call.wait is not None else "runs"
    for frame in frames_of(call):
        key = (frame.f_globals.get("__name__", ""), frame.f_code.co_name)
        if key in _FUNCTIONS:
            reason = _FUNCTIONS[key].format(self=frame.f_locals.get("self"))
    return reason
