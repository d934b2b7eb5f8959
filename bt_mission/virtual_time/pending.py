"""What is left to run of a callback."""

from __future__ import annotations

from collections.abc import Coroutine
from typing import Any

PendingCallback = Coroutine[Any, Any, None] | None
"""The coroutine of a callback that was begun; None when the callback has ended."""
