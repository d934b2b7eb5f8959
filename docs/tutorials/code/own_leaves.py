"""Two leaves for missions: docs/tutorials/own-leaf.md."""

from py_trees.behaviour import Behaviour
from py_trees.common import Status


class Countdown(Behaviour):
    """Counts down, a tick each, and says so."""

    ticks: int = 3  # an input
    said: str = ""  # an output

    def initialise(self):
        """Begin: the inputs have their values now."""
        self.left = self.ticks

    def update(self):
        """One tick."""
        self.left -= 1
        self.said = f"{self.left} to go"
        self.feedback_message = self.said
        return Status.RUNNING if self.left > 0 else Status.SUCCESS


class Slower(Behaviour):
    """Succeeds once some seconds of ROS time are over, more of them each time."""

    seconds: float = 1.0  # an input, s
    waited: float = 0.0  # an output, s

    def setup(self, runtime, **_):
        """Take the mission's runtime: its clock, and its log."""
        self.runtime = runtime
        self.times = 0

    def initialise(self):
        """Begin."""
        self.times += 1
        self.start_ns = self.runtime.now_ns

    def update(self):
        """Look at the clock; never wait in here."""
        self.waited = (self.runtime.now_ns - self.start_ns) / 1e9
        if self.waited < self.seconds * self.times:
            return Status.RUNNING
        self.runtime.log(f"waited for {self.waited:.2f} s")
        return Status.SUCCESS
