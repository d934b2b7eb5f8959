"""More than a server can do: it says no, and goes on."""

from __future__ import annotations

from typing import Any

import pytest

from bt_mission.core.goal_rate import MOST_GOALS


@pytest.mark.parametrize("name", ["turn"])
def test_goals_beyond_the_limit_are_rejected_at_once(bench: Any, name: str) -> None:
    """Each with an answer; after ten seconds goals are accepted again."""
    sent = []
    for _ in range(MOST_GOALS // 10 + 2):
        sent += [bench.send(name) for _ in range(10)]
        bench.steps(1)
    assert [one.accepted for one in sent] == [True] * MOST_GOALS + [False] * 20
    assert "within 10 s, which is the limit" in bench.servers.why_rejected(f"/{name}")
    assert len(bench.commands) >= MOST_GOALS // 10
    bench.steps(200)
    again = bench.send(name)
    bench.steps(2)
    assert again.accepted is True
