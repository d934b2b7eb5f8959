"""The reference of the search: its tables and its example are those of the program."""

from __future__ import annotations

import re
from pathlib import Path

from bt_mission.core.yaml.document import read_text
from bt_mission.search.guide import AIMS
from bt_mission.search.kinds import GROUPS
from bt_mission.search.ranges import RangesFile
from bt_mission.search.strategies import STRATEGIES

PAGE = Path("docs/reference/search.md").read_text(encoding="utf-8")
HOW_TO = Path("docs/how-to/break-your-mission.md").read_text(encoding="utf-8")


def test_the_groups_of_faults() -> None:
    """Each with its faults."""
    rows = re.findall(r"^\| `(\w+)` \| ([\w, ]+) \|$", PAGE, re.MULTILINE)
    told = {name: tuple(kinds.split(", ")) for name, kinds in rows}
    assert {name: told.get(name) for name in GROUPS} == dict(GROUPS)


def test_the_files_of_ranges() -> None:
    """Those that are shown are read."""
    pages = re.findall(
        r"^```yaml\n((?:# ranges.yaml\n)?(?:seeds|inputs):.*?)^```",
        PAGE + HOW_TO,
        re.DOTALL | re.MULTILINE,
    )
    assert len(pages) == 2
    for text in pages:
        RangesFile(read_text(text))


def test_what_can_be_searched_for_and_how() -> None:
    """Every aim and strategy has a row."""
    for name in (*AIMS, *STRATEGIES):
        assert f"| `{name}` |" in PAGE
