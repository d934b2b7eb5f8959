"""What a page may send: one small JSON object a message, checked before anything is done."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from bt_mission.core.errors import BtMissionError

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
}
"""What changes something for everybody who looks on, with what it takes."""

QUESTIONS: Mapping[str, str] = {
    "select": "node",
    "map": "is_on",
    "camera": "is_on",
    "series": "name",
}
"""What a page asks for itself alone."""


class PageRequestError(BtMissionError):
    """What has come is no request of our page."""


@dataclass(frozen=True)
class PageRequest:
    """What a page wants.

    Attributes:
        do: One of :data:`CONTROLS` or :data:`QUESTIONS`.
        node: Index of the node it is about.
    """

    do: str
    node: int = 0
    name: str = ""
    is_on: bool = False


def read_request(text: str) -> PageRequest:
    """Read a message of a page.

    Raises:
        PageRequestError: For anything that our page does not send.
    """
    if len(text) > LONGEST:
        raise PageRequestError(f"a message of {len(text)} characters, at most {LONGEST}")
    try:
        request = json.loads(text)
    except (ValueError, RecursionError):
        raise PageRequestError("the message is no JSON") from None
    if not isinstance(request, dict) or not isinstance(request.get("do"), str):
        raise PageRequestError("the message is no request: expected an object with 'do'")
    do = request.pop("do")
    needed = {**CONTROLS, **QUESTIONS}.get(do)
    if needed is None:
        raise PageRequestError("the message asks for what there is not")
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
