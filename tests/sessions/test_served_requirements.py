"""Requirements of missions that come as goals of ``execute_mission``."""

from __future__ import annotations

from typing import Any

import pytest
from bt_mission_interfaces.action import ExecuteMission
from bt_mission_interfaces.msg import Requirements
from rclpy.action import ActionClient

from action_servers.core.error_codes import ErrorCode
from bt_mission.core.dds.liveliness import EXECUTIVE_LOST
from bt_mission.ros.graph import LATCHED
from bt_mission.sessions.mission_server import VIOLATED
from tests.support.mission_goals import Sent
from tests.support.project import ROOT


@pytest.fixture
def send(ros: Any) -> Any:
    """Send a mission to the executive."""
    client = ActionClient(ros.client, ExecuteMission, "execute_mission")
    return lambda **fields: Sent(ros, client, **fields)


JUDGED = """\
mission: m
requirements:
  is quick: always time < 1.22
  ends: eventually succeeded("later")
tree:
  wait: {}
  name: later
"""


def test_a_violated_requirement_aborts_the_goal(ros: Any, send: Any) -> None:
    """As it gives `run` the exit code 1; the summary has every verdict."""
    ros.serve()
    status, result = send(text=JUDGED.format(2)).end()
    assert (status, result.status, result.error_code) == ("aborted", "success", VIOLATED)
    # what decides is the last instant
    assert result.error_msg.startswith("requirement is quick: violated by 0.78 s at 2.00 s")
    *_, quick, ends = result.summary.splitlines()
    assert quick == f"  {result.error_msg}"
    assert ends.startswith("  requirement ends: holds")


def test_requirements_that_hold_are_in_the_summary(ros: Any, send: Any) -> None:
    """Its goal succeeds."""
    ros.serve()
    status, result = send(text=JUDGED.format(1)).end()
    assert (status, result.error_code, result.error_msg) == ("succeeded", 0, "")
    assert "requirement is quick: holds by 0.22 s" in result.summary


def test_the_requirements_of_the_next_mission_replace_those_of_the_last(
    ros: Any, send: Any
) -> None:
    """On the topic for tools, also where it has none."""
    reports: list[list[str]] = []
    ros.serve()
    ros.client.create_subscription(
        Requirements,
        "/bt_mission/requirements",
        lambda message: reports.append([requirement.name for requirement in message.requirements]),
        LATCHED,
    )
    send(text=JUDGED.format(1)).end()
    send(text="mission: m\ntree: {wait: 1}\n").end()
    assert reports[0] == ["is quick", "ends"]
    assert reports[-1] == []


def test_the_code_of_a_violation_is_that_of_the_definition() -> None:
    """Constants are no part of a type, so interfaces without it have the same hash."""
    text = (ROOT / "interfaces/bt_mission_interfaces/action/ExecuteMission.action").read_text()
    assert f"uint16 VIOLATED={VIOLATED} " in text
    assert VIOLATED not in (EXECUTIVE_LOST, *ErrorCode)


MEASURED = """\
mission: m
requirements:
  starts once: always count(starts(running("later"))) <= 1
  goes evenly: always abs(rate(time) - 1) < 0.5
  is late: eventually mean(time) over 0.5 s > 0.9
  takes its time: >-
    whenever ends(running("later")):
    time - value(time) at last starts(running("later")) > 1
observe: 1
tree:
  sequence:
    - wait: 0.3
    - {wait: 1.2, name: later}
"""


def test_counts_means_and_rates_need_no_simulation(ros: Any, send: Any) -> None:
    """A served mission is judged by what its executive knows, also in an observation."""
    ros.serve()
    status, result = send(text=MEASURED).end()
    assert (status, result.status, result.error_code) == ("succeeded", "success", 0)
    assert [line.strip() for line in result.summary.splitlines() if "requirement" in line] == [
        "requirement starts once: holds by 0 at 0.30 s",
        "requirement goes evenly: holds by 0.5 at 2.10 s",
        "requirement is late: holds by 1.35 s at 2.50 s",
        "requirement takes its time: holds by 0.2 s at 1.50 s",
    ]
