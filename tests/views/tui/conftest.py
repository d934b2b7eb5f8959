"""Views whose notices stand as long as a test looks."""

from __future__ import annotations

import pytest

from bt_mission.views.tui import view_app


@pytest.fixture(autouse=True)
def _notices_that_stay(monkeypatch: pytest.MonkeyPatch) -> None:
    """However slow the machine is."""
    monkeypatch.setattr(view_app, "NOTICE_S", 3600.0)
