"""A mission that is shown to pages, which needs the extra ``web``."""

from __future__ import annotations

from importlib.util import find_spec

import pytest

from bt_mission.views.web.live import LiveMission
from tests.support.watched import ScriptedExecutive, ScriptedGraph

NEEDED = ("starlette", "uvicorn", "websockets")
SERVING = ["test_gate.py", "test_server.py", "test_run.py", "test_in_browser.py"]

collect_ignore_glob = [] if all(find_spec(name) for name in NEEDED) else SERVING


@pytest.fixture
def executive() -> ScriptedExecutive:
    """One whose mission has begun."""
    executive = ScriptedExecutive()
    executive.begin()
    return executive


@pytest.fixture
def shown(executive: ScriptedExecutive) -> LiveMission:
    """It, for pages."""
    return LiveMission(ScriptedGraph(executive))
