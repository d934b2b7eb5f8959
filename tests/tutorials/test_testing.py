"""The tests on the pages pass as they stand, in an empty folder."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import pytest
import scipy.ndimage  # noqa: F401 - imported once, as NumPy

import bt_mission.testing.stages  # noqa: F401 - NumPy cannot be imported anew by each inner session
from tests.support.project import ROOT
from tests.support.thorough import sample

TEXT = (ROOT / "docs/reference/testing.md").read_text(encoding="utf-8")
NAMED = re.compile(r"`(\S+\.(?:yaml|py))`[^`]*```\w+\n(.*?)```", re.DOTALL)
PYTHON = re.compile(r"```python\n(.*?)```", re.DOTALL)


@pytest.fixture
def folder(pytester: pytest.Pytester) -> pytest.Pytester:
    """The folder of the first chapter."""
    files = dict(NAMED.findall(TEXT))
    assert sorted(files) == ["hall.yaml", "test_there.py", "there.yaml"]
    for name, text in files.items():
        (pytester.path / name).write_text(text, encoding="utf-8")
    return pytester


@pytest.mark.thorough
def test_the_three_tests_pass(folder: pytest.Pytester) -> None:
    """As a user's own."""
    result = folder.runpytest("-p", "no:cacheprovider", "-p", "no:randomly")
    result.assert_outcomes(passed=3)


def examples() -> Iterator[Any]:
    """Every other test of the page; what is no whole test is part of one."""
    for block in PYTHON.findall(TEXT):
        name = re.search(r"def (test_\w+)", block)
        if name is not None and name[1] != "test_it_stops_before_the_wall":
            marks = [pytest.mark.process] if "live_graph" in block else []
            yield pytest.param(block, id=name[1], marks=marks)


@pytest.mark.parametrize("block", sample(list(examples()), 9))
def test_every_other_example_passes(folder: pytest.Pytester, block: str) -> None:
    """With the mission and the world of the first chapter."""
    (folder.path / "test_there.py").write_text(block, encoding="utf-8")
    result = folder.runpytest("-p", "no:cacheprovider", "--scenario-seeds", "1")
    result.assert_outcomes(passed=block.count("def test_"))


@pytest.mark.thorough
def test_the_mission_of_the_first_tutorial_passes_its_tests(pytester: pytest.Pytester) -> None:
    """Its last form, with the tests of the page."""
    text = (ROOT / "docs/tutorials/first-mission.md").read_text(encoding="utf-8")
    mission = re.findall(r"```yaml mine.yaml\n(.*?)```", text, re.DOTALL)[-1]
    (pytester.path / "mine.yaml").write_text(mission, encoding="utf-8")
    (pytester.path / "test_mine.py").write_text("".join(PYTHON.findall(text)), encoding="utf-8")
    pytester.runpytest("-p", "no:cacheprovider").assert_outcomes(passed=2)
