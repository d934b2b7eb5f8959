"""A live executor, for recordings of a running graph."""

from tests.support.live_rig import live

__all__ = ["live"]
