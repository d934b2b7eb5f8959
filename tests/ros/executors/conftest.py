"""An executor of the wall clock with nodes made on demand."""

from tests.support.live_rig import live

__all__ = ["live"]
