"""Benchmarks are run one after another, and two commits in turns."""

from __future__ import annotations

import asyncio
import os
from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.harness.benchmark import Figure
from benchmarks.harness.measurement import Measurement
from benchmarks.harness.running import Plan, Runner

pytestmark = pytest.mark.process

FAILS = "raise SystemExit('there is no robot')"
WAITS = """\
import os, signal
with open("told", "w") as told:
    told.write(str(os.getpid()))
signal.pause()
"""


def run(plan: Plan, *benchmarks) -> list[Measurement]:
    """Run them; gives what was measured."""
    runner = Runner(plan, benchmarks)
    asyncio.run(runner.run())
    return runner.done


def test_a_benchmark_gives_a_value_for_each_round(tree, cost, capfd):
    """Its own number of rounds; what it prints is seen, progress goes to standard error."""
    (found,) = run(Plan(tree("new", 2.0)), cost)
    assert found.failures == []
    assert found.figures["cost"].new == [2.0, 2.0, 2.0]
    out, err = capfd.readouterr()
    assert out == "measured\n"
    assert "[0 of 1] cost: 3 rounds, a minute" in err
    assert "[1 of 1] cost: done in" in err


def test_a_smoke_is_one_round_and_quiet(tree, cost, capfd):
    """What it prints is of no interest."""
    (found,) = run(Plan(tree("new", 2.0), smoke=True, jobs=2), cost)
    assert found.figures["cost"].new == [2.0]
    assert capfd.readouterr().out == ""


def test_two_commits_are_measured_in_turns(tree, cost):
    """By the script of the new one; each round gives a ratio."""
    plan = Plan(tree("new", 3.0), tree("old", 2.0, FAILS), rounds=2)
    (found,) = run(plan, cost)
    values = found.figures["cost"]
    assert (values.new, values.old, values.ratios) == ([3.0, 3.0], [2.0, 2.0], [1.5, 1.5])
    assert (found.failures, found.old_lacks, found.old_script) == ([], "", False)


def test_the_old_commit_is_measured_by_its_own_script_where_the_new_one_fails(tree, cost):
    """Such as one that uses what was not there yet; the report says so."""
    new = tree("new", 3.0)
    script = new.root / "benchmarks" / "cost.py"
    script.write_text(
        f"import os; assert os.getcwd() == {str(new.root)!r}\n" + script.read_text(), "utf-8"
    )
    (found,) = run(Plan(new, tree("old", 2.0), rounds=2), cost)
    assert found.figures["cost"].old == [2.0, 2.0]
    assert found.old_script


def test_what_the_old_commit_lacks_is_said(tree, cost, capfd):
    """The new one is measured all the same, and nothing has failed."""
    new = tree("new", 3.0)
    script = new.root / "benchmarks" / "cost.py"
    script.write_text(
        f"import os; assert os.getcwd() == {str(new.root)!r}\n" + script.read_text(), "utf-8"
    )
    (found,) = run(Plan(new, tree("old", 2.0, FAILS), rounds=2), cost)
    values = found.figures["cost"]
    assert (values.new, values.old, values.ratios) == ([3.0, 3.0], [], [])
    assert found.old_lacks == "old lacks it: there is no robot"
    assert found.failures == []
    assert capfd.readouterr().err.count("old lacks it") == 1


def test_a_benchmark_that_fails_is_told_with_its_last_words(tree, cost):
    """The others run."""
    new = tree("new", 1.0)
    (new.root / "benchmarks" / "broken.py").write_text(FAILS, encoding="utf-8")
    broken = replace(cost, name="broken", commands=("broken.py",))
    first, second = run(Plan(new, smoke=False), broken, cost)
    assert [one.partition(":")[0] for one in first.failures] == ["broken.py ended with exit code 1"]
    assert second.failures == []


def test_a_figure_that_is_not_given_is_a_failure(tree, cost):
    """A benchmark that measures nothing any more would go unnoticed."""
    wanted = replace(cost, figures=(Figure("cost"), Figure("size")))
    (found,) = run(Plan(tree("new", 1.0), smoke=True), wanted)
    assert found.failures == ["it has not given 'size'"]


def test_a_process_ends_when_the_run_is_interrupted(tree, cost, tmp_path: Path):
    """With all that it has started; none is left behind."""
    new = tree("new", 1.0, WAITS)
    os.mkfifo(new.root / "told")

    async def interrupt() -> int:
        read = os.open(new.root / "told", os.O_RDONLY | os.O_NONBLOCK)
        loop, told = asyncio.get_running_loop(), asyncio.Event()
        loop.add_reader(read, told.set)
        task = asyncio.ensure_future(Runner(Plan(new), [cost]).run())
        await told.wait()
        loop.remove_reader(read)
        pid = int(os.read(read, 20))
        os.close(read)
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task
        return pid

    pid = asyncio.run(interrupt())
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)


@pytest.mark.parametrize(
    ("script", "failure"),
    [
        ("raise SystemExit('there is no robot')", "exit code 1:\n    there is no robot"),
        ("raise SystemExit(5)", "exit code 5"),
        ("import os, signal; os.kill(os.getpid(), signal.SIGKILL)", "signal 9"),
    ],
)
def test_a_script_of_the_smoke_ends_as_python_would_end_it(tree, cost, script, failure):
    """Though it is a fork of a process that has the libraries."""
    (found,) = run(Plan(tree("new", 1.0, script), smoke=True), cost)
    assert found.failures[0] == f"cost.py ended with {failure}"


def test_what_a_benchmark_finds_fails_a_measurement_and_no_smoke(tree, cost, capfd):
    """What it finds may be the load of the machine; that it works is seen all the same."""
    plan = Plan(tree("new", 1.0, "print('0 of 1'); raise SystemExit(3)"))
    (found,) = run(plan, cost)
    assert found.failures[0] == "cost.py ended with exit code 3"
    (found,) = run(replace(plan, smoke=True), cost)
    assert found.failures == []
    said = capfd.readouterr().err
    assert "cost works; what it found means nothing here: cost.py ended with exit code 3" in said
    assert "0 of 1" in said


def test_a_script_of_the_smoke_is_the_main_module(tree, cost):
    """Its classes come back from processes that it starts, its arguments and folder are its own."""
    script = (
        "import multiprocessing, sys, os\n"
        "class Found: pass\n"
        "def find(_): return Found()\n"
        "if __name__ == '__main__':\n"
        "    with multiprocessing.get_context('spawn').Pool(1) as pool:\n"
        "        assert isinstance(pool.map(find, [1])[0], Found)\n"
        "    assert sys.argv[1:] == ['1'] and os.path.exists('cost.txt')\n"
        "    assert sys.path[0] == os.path.dirname(__file__)\n"
        "    raise SystemExit(4)\n"
    )
    (found,) = run(Plan(tree("new", 1.0, script), smoke=True), cost)
    assert found.failures[0] == "cost.py ended with exit code 4"
