"""Executors with nodes made on demand."""

from tests.support.live_rig import live
from tests.support.rig import rig

__all__ = ["live", "rig"]
