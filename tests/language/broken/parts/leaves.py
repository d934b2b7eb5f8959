"""Leaves for a mission with mistakes."""

from py_trees.behaviour import Behaviour


class Countdown(Behaviour):
    """Declares what it takes and gives."""

    ticks: int = 3
    said: str = ""


def helper():
    """No behaviour."""
