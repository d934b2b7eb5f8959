"""What passes between the client of an action and its server, for those who look on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Exchange:
    """A request to one of the three services of an action, or the answer to it.

    Args:
        action: Resolved name of the action; ``type_name`` is its type.
        service: ``send_goal``, ``cancel_goal`` or ``get_result``.
        goal_id: The goal that it is about.
        request: As it was sent.
        answer: As it came; None when this tells of the request.
    """

    action: str
    type_name: str
    service: str
    goal_id: bytes
    request: Any
    answer: Any = None


ExchangeListener = Callable[[Exchange], None]
"""Told of each request when it is sent, and once more when it is answered."""
