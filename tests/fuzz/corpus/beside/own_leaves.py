"""Behaviours for the missions of the corpus."""

from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status


class Countdown(Behaviour):
    """Runs for some ticks; declares what it takes and gives."""

    ticks: int = 3
    said: str = ""
    share: float = 0.5
    anything: Any = None

    def initialise(self):
        """Begin anew."""
        self.left = self.ticks

    def update(self):
        """Count down."""
        self.left -= 1
        self.said = f"{self.left} left"
        return Status.RUNNING if self.left > 0 else Status.SUCCESS
