"""The log of a ROS node, which goes to a terminal and to ``/rosout``."""

from __future__ import annotations

import os
import sys
from typing import Any

from bt_mission.base.text import escape_lines

_FILE = os.path.realpath(__file__)


class EscapingLogger:
    """A logger of rclpy that escapes every text, except line feeds.

    Args:
        logger: The logger of a node.
    """

    def __init__(self, logger: Any) -> None:
        self._logger = logger
        # rclpy distinguishes calls, for `throttle_duration_sec`, by the first frame outside of
        # these files.
        callers = getattr(sys.modules[type(logger).__module__], "_internal_callers", [])
        if _FILE not in callers:
            callers.append(_FILE)

    def get_child(self, name: str) -> EscapingLogger:
        """Return the logger of a part of the node."""
        return EscapingLogger(self._logger.get_child(name))

    def set_level(self, level: Any) -> None:
        """Pass over what is less important; a process that logs even less stays as it is."""
        self._logger.set_level(0)
        if self._logger.get_effective_level() < level:
            self._logger.set_level(level)

    def info(self, text: str, **filters: Any) -> bool:
        """Log a line; the filters are those of rclpy. Return whether it was logged."""
        return bool(self._logger.info(escape_lines(text), **filters))

    def warning(self, text: str, **filters: Any) -> bool:
        """Log what may be wrong."""
        return bool(self._logger.warning(escape_lines(text), **filters))

    def error(self, text: str, **filters: Any) -> bool:
        """Log what is wrong."""
        return bool(self._logger.error(escape_lines(text), **filters))


def log_of(node: Any) -> EscapingLogger:
    """Return the logger of a node."""
    return EscapingLogger(node.get_logger())
