"""Executors with nodes made on demand."""

from tests.support.graph import rig
from tests.support.live_rig import live

__all__ = ["live", "rig"]
