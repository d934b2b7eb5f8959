"""The command line of `python -m benchmarks`."""

from __future__ import annotations

import subprocess
import sys

import pytest

from benchmarks.harness.catalogue import CATALOGUE
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
        (["sweep_memory"], "did you mean 'sweep-memory'"),
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


@pytest.mark.process
def test_a_smoke_of_a_real_benchmark_passes():
    """From the command line to the figures, without a table: they mean nothing."""
    command = [sys.executable, "-m", "benchmarks", "goals", "--smoke"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (0, ""), done.stderr
    assert "[1 of 1]" in done.stderr
