"""An executor with nodes made on demand."""

from tests.support.graph import rig

__all__ = ["rig"]
