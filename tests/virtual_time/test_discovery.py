"""Endpoints of a process are waited for, for a bounded time, and named when they do not come."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import pytest

from bt_mission.virtual_time import DiscoveryError, discovery


def test_endpoints_that_come_a_little_later_are_waited_for(
    rig: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Virtual time stands still meanwhile."""
    looks: list[int] = []

    def later(_: Sequence[Any]) -> Iterator[str]:
        looks.append(1)
        if len(looks) < 5:
            yield "publisher of /late"

    monkeypatch.setattr(discovery, "unmatched", later)
    discovery.wait_for_matching([rig.node("a")])
    assert len(looks) == 5


def test_endpoints_that_never_come_are_named(rig: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """With what to do."""
    node = rig.node("a")
    monkeypatch.setattr(discovery, "ATTEMPTS", 3)
    monkeypatch.setattr(discovery, "unmatched", lambda _: iter(["publisher of /never"]))
    with pytest.raises(DiscoveryError, match="publisher of /never; run `bt-mission doctor`"):
        discovery.wait_for_matching([node])
