"""The command line of `python -m benchmarks`."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks.harness.catalogue import CATALOGUE
from benchmarks.harness.command import choose, main
from tests.support.project import ROOT


def test_without_a_name_all_are_listed(capsys):
    """One line each, and what to do next."""
    assert main([]) == 0
    *lines, empty, hint = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == [one.name for one in CATALOGUE]
    assert all(line.endswith(one.line) for line, one in zip(lines, CATALOGUE, strict=True))
    assert (empty, hint) == ("", "python -m benchmarks NAME ... runs some; --help says more")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["sped"], "there is no benchmark 'sped': did you mean 'speed'?"),
        (["speed.py", "xyz"], "'speed.py': did you mean 'speed'?"),
        (["xyz"], "there is no benchmark 'xyz': python -m benchmarks lists them"),
        (["sweep_memory"], "did you mean 'sweep-memory'"),
        (["table", "speed"], "'table' names its benchmarks itself: leave the other names out"),
        (["--smoke"], "name what is to be run, or 'all'"),
        (["speed", "--jobs", "2"], "--jobs is for --smoke"),
        (["speed", "--json", "/not/there.json"], "there is no folder '/not' to write"),
        (["speed", "--markdown", str(ROOT)], f"'{ROOT}' is a folder; name a file in it"),
        (["speed", "--against", "no such commit"], "git knows no commit 'no such commit' here"),
    ],
)
def test_what_is_wrong_is_said_before_anything_runs(arguments, words, capsys):
    """With exit code 2."""
    assert main(arguments) == 2
    assert words in capsys.readouterr().err


@pytest.mark.parametrize("rounds", ["0", "-1", "many"])
def test_rounds_are_a_whole_number_from_one(rounds, capsys):
    """Another is refused with what it was."""
    with pytest.raises(SystemExit, match="2"):
        main(["speed", "--rounds", rounds])
    assert f"expected a whole number from 1, got '{rounds}'" in capsys.readouterr().err


def test_names_are_run_in_their_order_and_once():
    """`all` is each of them, `table` those with a row of the table of targets."""
    assert [one.name for one in choose(["goals", "speed", "goals"])] == ["goals", "speed"]
    assert choose(["goals", "all"]) == list(CATALOGUE)
    names = [one.name for one in choose(["table"])]
    assert {
        "speed",
        "start",
        "image",
        "stage",
        "recording",
        "goals",
        "live",
        "scaling",
        "calls",
    } == set(names)


def test_the_help_teaches(capsys):
    """Examples, and what the exit codes mean."""
    with pytest.raises(SystemExit, match="0"):
        main(["--help"])
    said = capsys.readouterr().out
    for words in (
        "examples:",
        "--against main",
        "exit codes:",
        "table --busy 2",
        "speed.py --help",
    ):
        assert words in said


@pytest.mark.process
def test_a_smoke_of_real_benchmarks_goes_through(tmp_path: Path):
    """From the command line to the JSON: all declared figures have come."""
    file = tmp_path / "found.json"
    command = [sys.executable, "-m", "benchmarks", "speed", "shares", "halts", "--smoke"]
    done = subprocess.run(
        [*command, "--json", str(file)], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout) == (0, ""), done.stderr
    told = json.loads(file.read_text(encoding="utf-8"))
    assert told["smoke"]
    figures = {one["name"]: [each["name"] for each in one["figures"]] for one in told["benchmarks"]}
    assert figures["speed"][0] == "short: stage"
    assert figures["halts"] == [f"halting {n} goals, CPU of each" for n in (1, 10, 100)]
    assert figures["shares"][0] == "a step, CPU"
