"""The command line of `python -m benchmarks`, and its catalogue."""

from __future__ import annotations

import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks.harness.catalogue import CATALOGUE, Benchmark, Target
from benchmarks.harness.command import choose, main
from tests.support.project import ROOT


def test_without_a_name_all_are_listed(capsys):
    """One line each, and what to do next."""
    assert main([]) == 0
    *lines, empty, hint = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == [benchmark.name for benchmark in CATALOGUE]
    assert (empty, hint) == ("", "python -m benchmarks NAME ... runs some; --help says more")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["sped"], "there is no benchmark 'sped': did you mean 'speed'?"),
        (["speed.py", "xyz"], "'speed.py': did you mean 'speed'?"),
        (["xyz"], "there is no benchmark 'xyz': python -m benchmarks lists them"),
        (["safety_stops"], "did you mean 'safety-stops'"),
        (["table", "speed"], "'table' chooses its benchmarks: leave the other names out"),
        (["speed", "--against", "no such commit"], "git knows no commit 'no such commit' here"),
    ],
)
def test_a_mistake_is_reported_before_anything_runs(arguments, words, capsys):
    """With exit code 2."""
    assert main(arguments) == 2
    assert words in capsys.readouterr().err


@pytest.mark.parametrize("rounds", ["0", "-1", "many"])
def test_rounds_are_a_whole_number_from_one(rounds, capsys):
    """Another is refused with what it was."""
    with pytest.raises(SystemExit, match="2"):
        main(["speed", "--rounds", rounds])
    assert f"expected a whole number from 1, got '{rounds}'" in capsys.readouterr().err


def test_an_option_without_a_name_is_refused(capsys):
    """The list would ignore it."""
    with pytest.raises(SystemExit, match="2"):
        main(["--smoke"])
    assert "name what to run, or 'all'" in capsys.readouterr().err


def test_names_are_run_in_their_order_and_once():
    """`all` is each of them, `table` those of the table of targets."""
    assert [benchmark.name for benchmark in choose(["goals", "speed", "goals"])] == [
        "goals",
        "speed",
    ]
    assert choose(["goals", "all"]) == CATALOGUE
    assert {"speed", "calls", "recording"} <= {benchmark.name for benchmark in choose(["table"])}


@pytest.mark.thorough
@pytest.mark.process
def test_a_smoke_of_a_real_benchmark_passes():
    """From the command line to the figures, without a table: they mean nothing."""
    command = [sys.executable, "-m", "benchmarks", "goals", "--smoke"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (0, ""), done.stderr
    assert "[1 of 1]" in done.stderr


# ---- the catalogue: every script is in it, with a smoke ----------------------------------------


NOT_LISTED = {"benchmarks/__main__.py"}
"""The entry point."""
FOLDER = Path("/somewhere")


def scripts_of(benchmark):
    """The scripts that it starts."""
    return {shlex.split(text)[0] for text in (*benchmark.run, *benchmark.smoke)}


def test_every_script_is_listed():
    """So the smoke runs it, and none breaks unnoticed."""
    scripts = {
        str(path.relative_to(ROOT))
        for pattern in ("benchmarks/*.py", "benchmarks/commands/*/*.py", "campaigns/*.py")
        for path in ROOT.glob(pattern)
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
        if words[0] == "campaigns/campaign.py":
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
