"""The reference of the search: its tables and its example are those of the program."""

from __future__ import annotations

import re
from pathlib import Path

from bt_mission.core.yaml.document import read_text
from bt_mission.search.guide import AIMS
from bt_mission.search.strategies import STRATEGIES
from bt_mission.sweeps.ranges import FaultRanges, ObstacleRanges, Ranges, RangesFile

PAGE = Path("docs/reference/search.md").read_text(encoding="utf-8")
RANGES = Path("docs/reference/ranges.md").read_text(encoding="utf-8")
HOW_TO = Path("docs/how-to/break-your-mission.md").read_text(encoding="utf-8")


def test_the_files_of_ranges() -> None:
    """Those that are shown are read."""
    pages = re.findall(
        r"^```yaml\n((?:# ranges.yaml\n)?(?:seeds|inputs):.*?)^```",
        RANGES + HOW_TO,
        re.DOTALL | re.MULTILINE,
    )
    assert len(pages) == 2
    for text in pages:
        RangesFile(read_text(text))


def test_every_key_of_ranges_has_a_row() -> None:
    """With its default."""
    parts = {"obstacles": ObstacleRanges.model_fields, "faults": FaultRanges.model_fields}
    for key in Ranges.model_fields:
        for inner in parts.get(key, ()):
            assert re.search(rf"^\| [^|]*`({key})?\.{inner}`", RANGES, re.MULTILINE), inner
        assert key in parts or f"| `{key}` |" in RANGES


def test_what_can_be_searched_for_and_how() -> None:
    """Every aim and strategy has a row."""
    for name in (*AIMS, *STRATEGIES):
        assert f"| `{name}` |" in PAGE
