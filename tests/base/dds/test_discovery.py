"""Processes find each other on this machine only, unless asked."""

from __future__ import annotations

import os

import pytest

from bt_mission.base.dds.discovery import RANGE, isolate, restrict_discovery

THIS = "ROS domain 0, this machine only; --network includes other machines"
ALL = "ROS domain 7, all machines of the network (--network)"


@pytest.mark.parametrize(
    ("variable", "domain", "network", "output", "result"),
    [
        ("", "", False, THIS, "LOCALHOST"),
        *(
            (chosen, "", False, None, chosen)
            for chosen in ("SUBNET", "LOCALHOST", "OFF", "SYSTEM_DEFAULT")
        ),
        ("LOCALHOST", "7", True, ALL, "SUBNET"),
    ],
)
def test_what_the_variable_says_stays_unless_the_option_opens_the_network(
    monkeypatch: pytest.MonkeyPatch,
    *,
    variable: str,
    domain: str,
    network: bool,
    output: str | None,
    result: str,
) -> None:
    """Without either it is this machine; what is not in the variable is told."""
    monkeypatch.setenv(RANGE, variable)
    monkeypatch.setenv("ROS_DOMAIN_ID", domain)
    assert restrict_discovery(network=network) == output
    assert os.environ[RANGE] == result


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
