"""Samples of a run count for a part of it."""

from __future__ import annotations

import importlib
import random
import signal
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.support.project import ROOT


@pytest.fixture
def shares(monkeypatch: pytest.MonkeyPatch) -> Any:
    """The script."""
    monkeypatch.setattr(sys, "path", [str(ROOT / "benchmarks"), *sys.path])
    return importlib.import_module("shares")


@pytest.mark.parametrize(
    ("file", "function", "room"),
    [
        ("sim/physics/physics.py", "Physics.advance_to", "physics"),
        ("sim/sensors/lidar.py", "Lidar.measure", "lidar"),
        ("sim/sensors/imu.py", "Imu.read", "odometry and other sensors"),
        ("sim/ros/topics.py", "publish", "publishing by the simulation"),
        ("action_servers/robot_io/adapter.py", "ActionAdapter.on_feedback", "feedback"),
        ("action_servers/robot_io/adapter.py", "ActionAdapter.step", "sensors read, commands sent"),
        ("action_servers/core/pilot.py", "Pilot.step", "pilot and maneuvers"),
        ("bt_mission/executive/trace.py", "Trace.record", "trace"),
        ("bt_mission/executive/executive.py", "Executive.tick", "executive's tick"),
        ("bt_mission/executors/entities.py", "Entities.ready", "checks of what is ready"),
        ("bt_mission/ros/observable_publisher.py", "ObservablePublisher.publish", None),
        ("bt_mission/core/cdr/writer.py", "MessageTemplate.pack", None),
    ],
)
def test_a_function_belongs_to_the_part_of_its_file(shares, file, function, room):
    """What serves all parts, such as writing messages, counts for its caller."""
    assert shares.room_of(file, function) == room


def test_every_part_but_the_rest_has_files_that_are_there(shares):
    """A folder that is renamed would lose its samples to the rest."""
    for room, patterns in shares.ROOMS:
        for pattern in patterns:
            begin, _, function = pattern.partition("*")
            path = ROOT / begin
            if path.is_dir():
                sources = list(path.rglob("*.py"))
            else:
                sources = list(path.parent.glob(f"{path.name}*"))
            text = "".join(one.read_text(encoding="utf-8") for one in sources if one.is_file())
            assert sources, f"{room}: {pattern}"
            assert function in text, f"{room}: {pattern}"


def test_a_sample_counts_for_the_innermost_function_of_a_part(shares, tmp_path: Path):
    """A library above it is passed over; a stack without any is the rest."""
    samples = shares.Samples(tmp_path)
    code = "def serve(take):\n    take()\n"
    for name in ("bt_mission/core/x.py", "sim/physics/x.py"):
        space: dict[str, Any] = {}
        exec(compile(code, str(tmp_path / name), "exec"), space)  # noqa: S102 - a function of that file
        if name.startswith("bt_mission"):
            library = space["serve"]
    physics = space["serve"]
    physics(lambda: library(lambda: samples.take(sys._getframe())))
    samples.take(sys._getframe())
    assert dict(samples.rooms) == {"physics": 1, "rest": 1}
    assert dict(samples.functions) == {"x.serve": 1}


def test_samples_are_taken_only_while_it_is_open(shares):
    """And the handler that was there is back."""
    before = signal.getsignal(signal.SIGALRM)
    samples = shares.Samples(ROOT)
    with shares.sampling(samples, random.Random(1)):
        while not samples.rooms:
            pass
    assert samples.rooms.total() >= 1
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)
    assert signal.getsignal(signal.SIGALRM) is before


def test_an_alarm_that_is_handled_late_does_not_start_the_timer_again(shares):
    """It would come where nobody handles it, and end the process."""
    samples = shares.Samples(ROOT)
    with shares.sampling(samples, random.Random(1)):
        handler = signal.getsignal(signal.SIGALRM)
    assert callable(handler)
    taken = samples.rooms.total()
    handler(signal.SIGALRM, None)
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)
    assert samples.rooms.total() == taken
