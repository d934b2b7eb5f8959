"""What people see while a sweep runs."""

from __future__ import annotations

from bt_mission.sweeps.progress import NO_WORKERS, SweepProgress


def test_it_says_that_no_worker_is_left():
    """The number of them otherwise."""
    progress = SweepProgress("explore", 10)
    assert progress.lines(0)[0].endswith(NO_WORKERS)
    assert progress.lines(1)[0].endswith("1 worker")
    assert progress.lines(2)[0].endswith("2 workers")
