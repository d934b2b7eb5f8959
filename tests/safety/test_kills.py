"""Processes that are killed with ``kill -9`` while the robot drives."""

from __future__ import annotations

import math
import signal
from typing import Any

import pytest

from bt_mission.base.dds.middleware import FAST_DDS, PROFILES
from tests.support.thorough import sample

pytestmark = pytest.mark.process

STANDSTILL = (0.0, 0.0)


@pytest.mark.parametrize("killed", sample(["servers", "executive"], 2))
def test_the_base_is_told_to_stand_and_stays(
    benchmark: Any, monkeypatch: pytest.MonkeyPatch, killed: str
) -> None:
    """With the arbiter before it, as on a real robot.

    How soon after the last command holds under any load; how soon after the kill is measured by
    campaigns/safety.py.
    """
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    kills = benchmark("safety_kills")
    kill = kills.kill(killed, with_arbiter=True)
    assert kill.stood_after_s < math.inf
    # However long a command was under way, its time to hold counts from when it was sent.
    assert kill.after_command_s <= 0.5 + kills.TRUTH_PERIOD_S
    assert kill.stayed
    assert STANDSTILL in kill.commands
    told_to_stand = kill.commands.index(STANDSTILL)
    assert set(kill.commands[told_to_stand:]) == {STANDSTILL}
    assert all(ahead <= kills.SPEED + 1e-9 for ahead, _ in kill.commands[:told_to_stand])


@pytest.mark.thorough
def test_an_executive_that_is_held_up_keeps_its_goal(
    benchmark: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Any
) -> None:
    """The base stands while its sign of life is late; then the same goal drives on."""
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    # However slow the machine, neither DDS nor the servers give the executive up meanwhile.
    settings = tmp_path / "fast_dds.xml"
    settings.write_text(FAST_DDS.read_text().replace("<sec>2</sec>", "<sec>200</sec>", 1))
    monkeypatch.setenv(PROFILES[0], str(settings))
    kills = benchmark("safety_kills")
    path = tmp_path / "servers.log"
    with (
        path.open("wb") as log,
        kills.driving(with_arbiter=False, log=log, parameters={"executive_timeout": 200.0}) as (
            processes,
            truth,
        ),
    ):
        processes["executive"].send_signal(signal.SIGSTOP)
        while not truth.stands():
            truth.newest()
        processes["executive"].send_signal(signal.SIGCONT)
        while truth.stands():
            truth.newest()
    text = path.read_text()
    assert "no sign of life of the executive for 0.2 s: the base is held" in text
    assert text.count("goal accepted") == 1
    assert "goal aborted" not in text
