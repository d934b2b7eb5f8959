"""The requests of a page: one small JSON object a message, checked first."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from bt_mission.base.errors import BtMissionError

LONGEST = 1_000
"""Characters of a message."""

CONTROLS: Mapping[str, str] = {
    "pause": "",
    "pause_keeping_goals": "",
    "resume": "",
    "step": "",
    "stop": "",
    "breakpoint": "node",
    "attach": "name",
    "fault": "name",
}
"""Requests that change something for all viewers, with their fields."""

QUESTIONS: Mapping[str, str] = {
    "select": "node",
    "map": "is_on",
    "camera": "is_on",
    "series": "name",
}
"""Requests of a page for itself."""


class PageRequestError(BtMissionError):
    """A message that is not a request of our page."""

    code = "BT-916"


@dataclass(frozen=True)
class PageRequest:
    """A request of a page.

    Attributes:
        do: One of :data:`CONTROLS` or :data:`QUESTIONS`.
        node: The index of its node.
    """

    do: str
    node: int = 0
    name: str = ""
    is_on: bool = False


def read_request(text: str) -> PageRequest:
    """Read a message of a page.

    Raises:
        PageRequestError: Our page does not send this.
    """
    if len(text) > LONGEST:
        raise PageRequestError(f"a message of {len(text)} characters, at most {LONGEST}")
    try:
        request = json.loads(text)
    except (ValueError, RecursionError):
        raise PageRequestError("the message is not JSON") from None
    if not isinstance(request, dict) or not isinstance(request.get("do"), str):
        raise PageRequestError("not a request: expected an object with 'do'")
    do = request.pop("do")
    needed = {**CONTROLS, **QUESTIONS}.get(do)
    if needed is None:
        raise PageRequestError("unknown request")
    allowed = {name for name in (needed, "node") if name}
    if not set(request) <= allowed or (needed and needed not in request):
        raise PageRequestError(f"'{do}' takes {needed or 'nothing'}")
    return PageRequest(do, **{key: _checked(key, value) for key, value in request.items()})


def _checked(key: str, value: Any) -> Any:
    if key == "node" and type(value) is int and 0 <= value < 1 << 31:
        return value
    if (key == "name" and isinstance(value, str)) or (key == "is_on" and isinstance(value, bool)):
        return value
    raise PageRequestError(f"'{key}' is none")
