"""An executor with nodes made on demand."""

from tests.support.rig import rig

__all__ = ["rig"]
