"""An executive that tells what the test says."""

from __future__ import annotations

import pytest

from tests.support.watched import ScriptedExecutive, begun


@pytest.fixture
def executive() -> ScriptedExecutive:
    """One whose mission has begun."""
    return begun()
