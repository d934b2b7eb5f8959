"""Processes find each other on this machine only, unless asked."""

from __future__ import annotations

import os

import pytest

from bt_mission.core.dds.discovery import RANGE, isolate, restrict_discovery


def test_where_nothing_is_said_it_is_this_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    """A message says so, and how to change it."""
    monkeypatch.setenv(RANGE, "")
    monkeypatch.setenv("ROS_DOMAIN_ID", "")
    output = restrict_discovery(network=False)
    assert output == "ROS domain 0, this machine only; --network includes other machines"
    assert os.environ[RANGE] == "LOCALHOST"


@pytest.mark.parametrize("chosen", ["SUBNET", "LOCALHOST", "OFF", "SYSTEM_DEFAULT"])
def test_what_the_variable_says_stays(monkeypatch: pytest.MonkeyPatch, chosen: str) -> None:
    """Then there is nothing to tell."""
    monkeypatch.setenv(RANGE, chosen)
    assert restrict_discovery(network=False) is None
    assert os.environ[RANGE] == chosen


def test_the_option_opens_the_network(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever the variable says."""
    monkeypatch.setenv(RANGE, "LOCALHOST")
    monkeypatch.setenv("ROS_DOMAIN_ID", "7")
    output = restrict_discovery(network=True)
    assert output == "ROS domain 7, all machines of the network (--network)"
    assert os.environ[RANGE] == "SUBNET"


@pytest.mark.parametrize(
    ("visible", "network", "result"),
    [(False, False, "OFF"), (True, False, "LOCALHOST"), (True, True, "SUBNET")],
)
def test_a_simulated_run_is_alone_unless_asked(
    monkeypatch: pytest.MonkeyPatch, *, visible: bool, network: bool, result: str
) -> None:
    """The variable does not open it: it may be there for a robot on the same network."""
    monkeypatch.setenv(RANGE, "SUBNET")
    isolate(visible=visible, network=network)
    assert os.environ[RANGE] == result
