"""Collections are spared while a command loads, and only where that was asked for."""

from __future__ import annotations

import gc
from collections.abc import Iterator

import pytest

from bt_mission.base.memory import WHILE_LOADING, settle_memory, spare_collections


@pytest.fixture(autouse=True)
def _as_before() -> Iterator[None]:
    thresholds, frozen = gc.get_threshold(), gc.get_freeze_count()
    yield
    gc.set_threshold(*thresholds)
    if not frozen:
        gc.unfreeze()


def test_what_is_loaded_is_taken_for_permanent() -> None:
    """From then on Python looks as often as before."""
    usual = gc.get_threshold()
    spare_collections()
    assert gc.get_threshold()[0] == WHILE_LOADING
    frozen = gc.get_freeze_count()
    kept = [[]]  # type: ignore[var-annotated]  # a container, which is looked through
    settle_memory()
    assert gc.get_freeze_count() > frozen
    assert gc.get_threshold() == usual
    assert kept == [[]]


def test_a_process_of_others_is_left_alone() -> None:
    """A test or a notebook that runs missions decides alone."""
    before = gc.get_freeze_count(), gc.get_threshold()
    settle_memory()
    assert (gc.get_freeze_count(), gc.get_threshold()) == before
