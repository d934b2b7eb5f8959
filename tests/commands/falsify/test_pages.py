"""The pages about searches list and show what there is."""

from __future__ import annotations

import re

from bt_mission.base.yaml.document import read_text
from bt_mission.commands.falsify.guide import AIMS
from bt_mission.scenarios.concrete.ranges import RangesFile
from tests.support.project import ROOT

SEARCH = (ROOT / "docs/reference/search.md").read_text(encoding="utf-8")
GUIDE = (ROOT / "docs/how-to/break-your-mission.md").read_text(encoding="utf-8")


def test_every_aim_of_a_search_has_a_row() -> None:
    """By its name."""
    assert [name for name in AIMS if f"| `{name}` |" not in SEARCH] == []


def test_the_file_of_ranges_of_the_guide_is_read() -> None:
    """As it stands there."""
    blocks = re.findall(r"^```yaml\n(.*?)^```$", GUIDE, re.MULTILINE | re.DOTALL)
    texts = [text for text in blocks if re.match(r"(# ranges.yaml\n)?(seeds|inputs):", text)]
    assert len([RangesFile(read_text(text)) for text in texts]) == 1
