"""docs/reference/sources.md: every row of the courses is there, and what it names exists."""

import re

import pytest

from tests.support.project import ROOT

PAGE = ROOT / "docs" / "reference" / "sources.md"
TEXT = PAGE.read_text(encoding="utf-8")
ROWS = re.findall(r"^(\d+)\. (.*(?:\n   .*)*)", TEXT, re.MULTILINE)
FILES = sorted(set(re.findall(r"`([a-z_/]+\.(?:yaml|py))`", TEXT)))


def test_every_system_has_a_row_with_a_mission():
    """Twenty-nine of them."""
    numbers = [int(number) for number, _ in ROWS]
    assert numbers == list(range(1, 30))
    assert all(".yaml" in text or text.endswith(": any") for _, text in ROWS)


@pytest.mark.parametrize("name", FILES)
def test_a_file_that_is_named_exists(name):
    """In missions/sources, unless a folder is named."""
    assert (ROOT / (name if "/" in name else f"missions/sources/{name}")).is_file()


def test_every_mission_of_the_folder_is_named():
    """With the row that it covers."""
    shipped = {path.name for path in (ROOT / "missions" / "sources").glob("*.yaml")}
    assert shipped <= set(FILES)
