"""The settings of Fast DDS that our processes have."""

from __future__ import annotations

import os
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest

from bt_mission.base.dds.discovery import RANGE
from bt_mission.base.dds.middleware import ALONE, FAST_DDS, LOOPBACK, PROFILES, prepare_middleware

NAMESPACE = "{http://www.eprosima.com}"


@pytest.fixture(autouse=True)
def _no_settings(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in (*PROFILES, "ROS_STATIC_PEERS"):
        monkeypatch.setenv(name, "")


@pytest.mark.parametrize(
    ("reach", "peers", "profile"),
    [
        ("LOCALHOST", "", LOOPBACK),
        ("LOCALHOST", "192.0.2.7", FAST_DDS),
        ("OFF", "", FAST_DDS),
        ("OFF", "192.0.2.7", FAST_DDS),
        ("SUBNET", "", FAST_DDS),
        ("", "", FAST_DDS),
    ],
)
def test_what_this_machine_alone_may_find_is_bound_to_the_loopback_interface(
    monkeypatch: pytest.MonkeyPatch, reach: str, peers: str, profile: object
) -> None:
    """Unless other machines are named as peers."""
    monkeypatch.setenv("ROS_STATIC_PEERS", peers)
    for range_ in ("SUBNET", "LOCALHOST", "OFF", reach):
        monkeypatch.setenv(RANGE, range_)
        prepare_middleware()
    assert os.environ[PROFILES[0]] == str(profile)


def test_who_is_alone_for_good_has_no_port(monkeypatch: pytest.MonkeyPatch) -> None:
    """That is said for a process, and not concluded from its reach, which may change later."""
    monkeypatch.setenv(RANGE, "OFF")
    prepare_middleware(alone=True)
    assert os.environ[PROFILES[0]] == str(ALONE)


def test_settings_of_the_users_own_stay(monkeypatch: pytest.MonkeyPatch) -> None:
    """Under either name of the variable."""
    monkeypatch.setenv(RANGE, "LOCALHOST")
    monkeypatch.setenv(PROFILES[1], "mine.xml")
    prepare_middleware()
    assert [os.environ[name] for name in PROFILES] == ["", "mine.xml"]


def test_both_files_have_the_same_leases() -> None:
    """A process that dies is missed as soon on this machine as on the network."""
    first, other = (_builtin_settings(file) for file in (FAST_DDS, LOOPBACK))
    assert first == other


def _builtin_settings(file: Path) -> bytes:
    result = ET.parse(file).find(f".//{NAMESPACE}builtin")  # noqa: S314 - a file of our own
    assert result is not None
    return ET.tostring(result)
