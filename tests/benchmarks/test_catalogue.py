"""Every script of benchmarks/ and campaigns/ is in the catalogue, with a smoke."""

from __future__ import annotations

import shlex
from pathlib import Path

import pytest

from benchmarks.harness.catalogue import CATALOGUE, Benchmark, Target
from tests.support.project import ROOT

NOT_LISTED = {"benchmarks/__main__.py", "campaigns/floods_client.py"}
"""The entry point, and what a campaign starts."""
FOLDER = Path("/somewhere")


def scripts_of(benchmark):
    """The scripts that it starts."""
    return {shlex.split(text)[0] for text in (*benchmark.run, *benchmark.smoke)}


def test_every_script_is_listed():
    """So the smoke runs it, and none breaks unnoticed."""
    scripts = {
        str(path.relative_to(ROOT))
        for folder in ("benchmarks", "campaigns")
        for path in (ROOT / folder).glob("*.py")
        if '__name__ == "__main__"' in path.read_text(encoding="utf-8")
    }
    assert scripts - NOT_LISTED == {name for known in CATALOGUE for name in scripts_of(known)}


@pytest.mark.parametrize("benchmark", CATALOGUE, ids=lambda known: known.name)
def test_an_entry_is_whole(benchmark):
    """It has a line and a smoke, which writes no results beside the sources and onto no page."""
    assert benchmark.name not in ("all", "table")
    assert benchmark.line
    assert benchmark.smoke
    assert benchmark.rounds == 1 or "{rounds}" in "".join(benchmark.run)
    assert all(str(target) for target in benchmark.targets.values())
    for text in benchmark.smoke:
        words = shlex.split(text)
        assert all(word.startswith("{folder}/") for word in words if word.endswith(".jsonl"))
        if words[0] == "campaigns/safety.py":
            assert "--no-page" in words
        if words[0] in ("campaigns/campaign.py", "campaigns/attached_campaign.py"):
            assert "--results" in words


def test_a_script_without_rounds_is_started_for_each():
    """One with rounds is started once, and so is each smoke; quoted words stay together."""
    with_rounds = Benchmark("a", "", ("a.py {rounds}",), ("a.py --only 'two words' {folder}/x",))
    without = Benchmark("b", "", ("a.py", "b.py"), ("a.py",))
    assert with_rounds.commands(4, FOLDER, smoke=False) == [["a.py", "4"]]
    assert without.commands(2, FOLDER, smoke=False) == [["a.py"], ["b.py"]] * 2
    assert with_rounds.commands(4, FOLDER, smoke=True) == [
        ["a.py", "--only", "two words", "/somewhere/x"]
    ]


@pytest.mark.parametrize(
    ("target", "met", "missed", "text"),
    [
        (Target(at_least=0.35, aim=0.5), 0.35, 0.34, "at least 0.35 (aim: 0.5)"),
        (Target(at_most=0), 0, 1, "at most 0"),
        (Target(at_most=0.8, of_old=True), 0.8, 0.81, "at most 0.8 x old"),
    ],
)
def test_a_target_is_met_at_its_bound(target, met, missed, text):
    """And says what it is."""
    assert (target.is_met(met), target.is_met(missed)) == (True, False)
    assert str(target) == text
