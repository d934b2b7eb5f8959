"""What our own leaves have in common: a tick without the work that only py_trees' log needs."""

from __future__ import annotations

from collections.abc import Iterator

from py_trees.behaviour import Behaviour
from py_trees.common import Status

RUNNING = Status.RUNNING


class Leaf(Behaviour):
    """A behaviour without children that ticks and stops as py_trees' own do, several times faster.

    At each tick and each stop py_trees formats a line for its log, whether or not anybody reads
    it, and lists all statuses to see whether the new one is among them; what our leaves return,
    the type checker sees. Leaves of users keep py_trees' own.
    """

    def tick(self) -> Iterator[Behaviour]:
        """Begin, if it does not run; update; stop, if it has ended."""
        if self.status is not RUNNING:
            self.initialise()
        status = self.update()
        if status is not RUNNING:
            self.stop(status)
        self.status = status
        yield self

    def stop(self, new_status: Status) -> None:
        """End with this status."""
        self.terminate(new_status)
        self.status = new_status
        self.iterator = self.tick()
