"""Captions."""

import numpy as np
import pytest
from PIL import ImageDraw

from bt_mission.commands.video.panel import Captions, PanelLeaf, panel
from bt_mission.executive.behaviours.leaves import LeafProgress
from tests.support.hostile import MARK, SHORT, filled, leaks

RUNNING = Captions(
    "explore", 3.2, "running", (PanelLeaf("drive", LeafProgress("m", 0.5, 2.0)),), "hello"
)


def test_a_panel_fills_its_place() -> None:
    """Of any size."""
    assert panel(RUNNING, 560, 300).shape == (300, 560, 3)


def test_progress_is_a_bar() -> None:
    """Longer, the farther a leaf has come."""

    def blue(value: float) -> int:
        leaf = PanelLeaf("drive", LeafProgress("m", value, 2.0))
        picture = panel(Captions("explore", 3.2, "", (leaf,)), 560, 300).astype(int)
        return int(((picture[..., 2] > 200) & (picture[..., 0] < 100)).sum())

    assert 0 < blue(0.5) < blue(1.5) == blue(1.5)
    assert blue(3.0) == blue(2.0)


def test_outcomes_have_colours() -> None:
    """Success is green, failure red."""
    for state, channel in (("success", 1), ("failure", 0)):
        chip = panel(Captions("explore", 3.2, state), 560, 300)[66:70, 60:120].mean(axis=(0, 1))
        assert chip.argmax() == channel


def test_what_is_too_long_is_cut() -> None:
    """Nothing is drawn at the right edge, whatever a mission is called and says."""
    long = "a very long name " * 20
    leaves = tuple(PanelLeaf(long, LeafProgress("s", 1.0, 2.0)) for _ in range(9))
    picture = panel(Captions(long, 3599.9, "running", leaves, long, long, long), 560, 300)
    assert np.ptp(picture[:, -20:].reshape(-1, 3), axis=0).max() == 0


def test_any_letter_can_be_said() -> None:
    """Also those that a font lacks, and none at all."""
    assert panel(Captions("\0\n\u202e日本", 0.0, "", (), "☃"), 560, 300).any()


def test_words_of_others_are_escaped(monkeypatch: pytest.MonkeyPatch) -> None:
    """They go into pixels, which would still be written from right to left."""
    drawn: list[str] = []
    monkeypatch.setattr(ImageDraw.ImageDraw, "text", lambda *given, **_: drawn.append(given[2]))
    panel(filled(Captions, f"{MARK}{SHORT}\nFORGED [reverse]m[/]"), 2000, 500)
    assert any(MARK in text for text in drawn)
    assert leaks("".join(drawn)) == []
