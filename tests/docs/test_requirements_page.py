"""The page on requirements: every example is one, and every signal and word is on it."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from bt_mission.language.checks.requirements import with_requirements
from bt_mission.language.requirements.formula import Formula
from bt_mission.language.requirements.parser import JOINING
from bt_mission.language.requirements.signals import SIGNALS
from bt_mission.sessions.load import load
from tests.support.project import ROOT

TEXT = (ROOT / "docs" / "reference" / "requirements.md").read_text()


def _blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", TEXT, re.DOTALL | re.MULTILINE)


MISSION = _blocks("yaml")[0]


def test_the_mission_is_one() -> None:
    """With all five requirements."""
    assert len(load(MISSION).requirements) == 5


def test_a_file_of_its_own_is_added(tmp_path: Path) -> None:
    """Behind those of the mission."""
    file = tmp_path / "slow.yaml"
    file.write_text(_blocks("yaml-file")[0])
    mission = with_requirements(load(MISSION), [file])
    assert [requirement.name for requirement in mission.requirements][-1] == "is slow"
    assert len(mission.requirements) == 6


@pytest.mark.parametrize("form", _blocks("yaml-requirement"))
def test_a_requirement_in_parts_is_one(form: str) -> None:
    """A mapping below a name, put into the mission of the page."""
    indented = "".join(f"  {line}\n" for line in form.splitlines())
    mission = load(re.sub(r"  keeps .*?(?=tree:)", lambda _: indented, MISSION, flags=re.DOTALL))
    assert [requirement.on_violation for requirement in mission.requirements] != ["report"]


@pytest.mark.parametrize(
    "text", [line for block in _blocks("requirements") for line in block.splitlines()]
)
def test_an_example_is_a_requirement(text: str) -> None:
    """It is parsed, and its types, units and windows fit."""
    assert Formula(text).text == text


def test_every_signal_and_word_is_described() -> None:
    """In a table or an example."""
    code = "".join(re.findall(r"`[^`]*`|```.*?```", TEXT, re.DOTALL))
    words = set(re.findall(r"[A-Za-z_.]+", code))
    assert set(SIGNALS) | JOINING <= words
