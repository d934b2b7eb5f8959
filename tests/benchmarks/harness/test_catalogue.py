"""All benchmarks are declared, and what is declared is there."""

from __future__ import annotations

import shlex

import pytest

from benchmarks.harness.catalogue import CATALOGUE
from tests.support.project import ROOT

SCRIPTS = ROOT / "benchmarks"
CAMPAIGNS = "../campaigns/"
CLIENTS = {"../campaigns/floods_client.py", "__main__.py"}
"""Started by benchmarks, and by Python."""
COVERED = {"executive.py"}
"""Its parts are benchmarks of their own."""


def scripts_of(benchmark):
    """The scripts that it starts."""
    return {shlex.split(text)[0] for text in (*benchmark.commands, *benchmark.smoke)}


def test_every_script_that_starts_by_itself_is_a_benchmark():
    """So the smoke runs it: none breaks without anybody noticing."""
    startable = {
        folder + path.name
        for folder in ("", CAMPAIGNS)
        for path in (SCRIPTS / folder).glob("*.py")
        if '__name__ == "__main__"' in path.read_text(encoding="utf-8")
    }
    assert startable - CLIENTS == {name for one in CATALOGUE for name in scripts_of(one)}


@pytest.mark.parametrize("benchmark", CATALOGUE, ids=lambda one: one.name)
def test_a_benchmark_is_whole(benchmark):
    """It has a line, figures, and a smoke of scripts that are there."""
    assert benchmark.line
    assert benchmark.figures
    assert benchmark.smoke
    assert all((SCRIPTS / name).is_file() for name in scripts_of(benchmark))
    assert benchmark.has_rounds or benchmark.rounds == 1


def test_names_are_unique():
    """Each is a word of the command line."""
    names = [one.name for one in CATALOGUE]
    assert len(set(names)) == len(names)
    assert not set(names) & {"all", "table"}


@pytest.mark.parametrize("benchmark", CATALOGUE, ids=lambda one: one.name)
def test_a_smoke_writes_no_results_beside_the_sources(benchmark):
    """What it writes goes into a temporary folder, or onto no page."""
    for text in benchmark.smoke:
        words = shlex.split(text)
        for option in ("--results", "--runs"):
            if option in words:
                assert words[words.index(option) + 1].startswith("{folder}/")
        if words[0] == CAMPAIGNS + "safety.py":
            assert "--no-page" in words
        if words[0] in (CAMPAIGNS + "campaign.py", CAMPAIGNS + "attached_campaign.py"):
            assert "--results" in words
        if words[0] == "coverage.py":
            assert {"--only-runs", "--runs"} <= set(words)
