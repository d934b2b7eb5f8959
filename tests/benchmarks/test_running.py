"""Benchmarks are run one after another, and two commits in turns, on copies with one line."""

from __future__ import annotations

import asyncio
import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.harness import tree as module
from benchmarks.harness.catalogue import Benchmark, Target
from benchmarks.harness.report import machine_line, markdown
from benchmarks.harness.running import Figure, Measurement, Plan, Runner
from benchmarks.harness.tree import ROOT, WITHOUT_EDITABLE, Tree, TreeError, checked_out
from benchmarks.measuring import spread

GIVES = """\
import json, os, pathlib, sys
line = {
    "figure": "cost",
    "unit": "ms",
    "values": [float(pathlib.Path("cost.txt").read_text())] * int(sys.argv[1]),
    "code": os.path.join(os.getcwd(), "bt_mission"),
}
with open(os.environ["BENCHMARK_FIGURES"], "a") as file:
    file.write(json.dumps(line) + "\\n")
print("measured")
"""
"""A script that gives what stands in a file of the folder it runs in, so many times."""

FAILS = "raise SystemExit('there is no robot')"
WAITS = """\
import os, signal
with open("told", "w") as told:
    told.write(str(os.getpid()))
signal.pause()
"""
OTHER_COPY = """\
import json, os
line = {"figure": "cost", "unit": "", "values": [1], "code": "/usr/lib/bt_mission"}
with open(os.environ["BENCHMARK_FIGURES"], "w") as file:
    json.dump(line, file)
"""


@pytest.fixture
def tree(tmp_path: Path) -> Callable[..., Tree]:
    """Make a copy: ``tree("new", 2.0)``, or with another script."""

    def make(name: str, cost: float, script: str = GIVES) -> Tree:
        root = tmp_path / name
        (root / "benchmarks").mkdir(parents=True)
        (root / "benchmarks" / "cost.py").write_text(script, encoding="utf-8")
        (root / "cost.txt").write_text(str(cost), encoding="utf-8")
        return Tree(root, name, (root,))

    return make


@pytest.fixture
def cost() -> Benchmark:
    """A benchmark that gives one figure."""
    run, smoke = "benchmarks/cost.py {rounds}", "benchmarks/cost.py 1"
    return Benchmark("cost", "what it costs", (run,), (smoke,), rounds=3)


def run(plan: Plan, *benchmarks) -> list[Measurement]:
    """Run them; gives what was measured."""
    runner = Runner(plan, benchmarks)
    asyncio.run(runner.run())
    return runner.done


def needs_new(new: Tree) -> Tree:
    """Let the script of a copy need that copy."""
    script = new.root / "benchmarks" / "cost.py"
    text = script.read_text("utf-8")
    script.write_text(f"import os; assert os.getcwd() == {str(new.root)!r}\n{text}", "utf-8")
    return new


@pytest.mark.process
def test_a_benchmark_gives_a_value_for_each_round(tree, cost, capfd):
    """Its own number of rounds, or one in a smoke, whose output is not shown."""
    (measured,) = run(Plan(tree("new", 2.0)), cost)
    assert (measured.failures, measured.figures["cost"].new) == ([], [2.0, 2.0, 2.0])
    out, err = capfd.readouterr()
    assert out == "measured\n"
    assert "[1 of 1] cost: done in" in err
    (measured,) = run(Plan(tree("small", 2.0), smoke=True, jobs=2), cost)
    assert measured.figures["cost"].new == [2.0]
    assert capfd.readouterr().out == ""


@pytest.mark.process
def test_two_commits_are_measured_in_turns(tree, cost):
    """By the script of the new one; each round gives a ratio."""
    (measured,) = run(Plan(tree("new", 3.0), tree("old", 2.0, FAILS), rounds=2), cost)
    assert measured.figures == {"cost": Figure("ms", [3.0, 3.0], [2.0, 2.0], [1.5, 1.5])}
    assert (measured.failures, measured.remark) == ([], "")


@pytest.mark.process
def test_where_the_new_script_fails_the_old_one_measures_its_own_commit(tree, cost):
    """Such as a script that uses what was not there yet; the remark says so."""
    (measured,) = run(Plan(needs_new(tree("new", 3.0)), tree("old", 2.0), rounds=2), cost)
    assert measured.figures["cost"].old == [2.0, 2.0]
    assert measured.remark == "the script of old has measured it"


@pytest.mark.process
def test_where_the_old_script_fails_too_the_new_commit_is_measured_alone(tree, cost):
    """Nothing has failed."""
    (measured,) = run(Plan(needs_new(tree("new", 3.0)), tree("old", 2.0, FAILS), rounds=2), cost)
    assert measured.figures["cost"] == Figure("ms", [3.0, 3.0])
    assert (measured.failures, measured.remark) == ([], "old lacks it: there is no robot")


@pytest.mark.process
@pytest.mark.parametrize(
    ("script", "failure"),
    [
        (FAILS, "benchmarks/cost.py ended with exit code 1\n    there is no robot"),
        (
            "import os, signal; os.kill(os.getpid(), signal.SIGKILL)",
            "benchmarks/cost.py ended with signal 9",
        ),
        ("pass", "it has given no figure"),
        (
            OTHER_COPY,
            (
                "expected to measure {}, got /usr/lib/bt_mission: this Python has another copy "
                "installed; use the environment of this checkout"
            ),
        ),
    ],
)
def test_a_failure_has_the_end_of_the_output(tree, cost, script, failure):
    """The other benchmarks run."""
    new = tree("new", 1.0, script)
    (new.root / "benchmarks" / "sound.py").write_text("raise SystemExit(3)", encoding="utf-8")
    sound = replace(cost, name="sound", smoke=("benchmarks/sound.py",))
    first, second = sorted(
        run(Plan(new, smoke=True), cost, sound), key=lambda measurement: measurement.benchmark.name
    )
    assert first.failures == [failure.format(new.root / "bt_mission")]
    assert second.failures == []


@pytest.mark.process
def test_findings_fail_a_campaign_and_no_smoke(tree, cost, capfd):
    """They may come from the load of the machine; that the script works is seen all the same."""
    plan = Plan(tree("new", 1.0, "print('0 of 1'); raise SystemExit(3)"))
    (measured,) = run(plan, cost)
    assert measured.failures == ["benchmarks/cost.py ended with exit code 3"]
    (measured,) = run(replace(plan, smoke=True), cost)
    assert measured.failures == []
    assert "exit code 3\n    0 of 1" in capfd.readouterr().err


@pytest.mark.process
def test_a_process_ends_when_the_run_is_interrupted(tree, cost):
    """With all that it has started."""
    new = tree("new", 1.0, WAITS)
    os.mkfifo(new.root / "told")

    async def interrupt() -> int:
        read = os.open(new.root / "told", os.O_RDONLY | os.O_NONBLOCK)
        loop, reported = asyncio.get_running_loop(), asyncio.Event()
        loop.add_reader(read, reported.set)
        task = asyncio.ensure_future(Runner(Plan(new), [cost]).run())
        await reported.wait()
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


# ---- the table -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("values", "unit", "text"),
    [
        ((3, 1, 2), "ms", "2.00 ms (1.00 to 3.00)"),
        ((1234.6,), "us", "1235 us"),
        ((0.1234, 0.25), "", "0.187 (0.123 to 0.250)"),
        ((0, 0), "", "0"),
        ((float("inf"),), "s", "inf s"),
        ((), "s", ""),
    ],
)
def test_a_spread_has_three_digits(values, unit, text):
    """And no brackets where all values look alike."""
    assert spread(values, unit) == text


def test_the_table_has_a_row_for_each_figure(cost):
    """Targets of a ratio are judged where there is one; the table of targets has only theirs."""
    targets = {"*: share": Target(at_least=0.35), "start": Target(at_most=0.8, of_old=True)}
    measured = Measurement(replace(cost, targets=targets))
    new = {"a: share": Figure("", [0.4]), "start": Figure("s", [0.5]), "size": Figure("MB", [3.0])}
    measured.add(new, {"start": Figure("s", [1.0])})
    measured.add({"a: share": Figure("", [0.2, 0.2])}, {"a: share": Figure("", [0])})
    measured.failures = ["cost.py ended with exit code 1\n    Traceback"]
    plan = Plan(Tree(Path(), "abc", ()), Tree(Path(), "old", ()))
    rows = [
        "| cost | a: share | 0 | 0.200 (0.200 to 0.400) |  | at least 0.35 | **no** |",
        "| cost | start | 1.00 s | 0.500 s | 0.500 | at most 0.8 x old | yes |",
        "| cost | size |  | 3.00 MB |  |  |  |",
    ]
    head = [
        "on a machine",
        "",
        "| benchmark | figure | old | abc | new to old | target | reached |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    end = ["", "- cost FAILED: cost.py ended with exit code 1"]
    every = markdown([measured], plan, "on a machine").splitlines()
    of_targets = markdown([measured], plan, "on a machine", with_target=True).splitlines()
    assert sorted(every) == sorted([*head, *rows, *end])
    assert sorted(of_targets) == sorted([*head, *rows[:2], *end])


def test_the_machine_is_described_with_its_load():
    """A smoke says that its figures mean nothing."""
    line = machine_line(Plan(Tree(ROOT, "abc", ()), smoke=True), 0.5, 2)
    assert line.startswith("A smoke, whose figures mean nothing: abc; medians")
    assert "load 0.5 before" in line
    assert line.endswith(", 2 processes computing beside it.")


# ---- another commit is there for a while -------------------------------------------------------


@pytest.fixture
def repository(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A repository with two commits, of which the first says `old`."""
    root = tmp_path / "repository"
    root.mkdir()
    names = ("-c", "user.name=somebody", "-c", "user.email=a@example.org")
    git("init", "-q", at=root)
    for word in ("old", "new"):
        (root / "word.txt").write_text(word, encoding="utf-8")
        git("add", ".", at=root)
        git(*names, "commit", "-q", "-m", word, at=root)
    monkeypatch.setattr(module, "ROOT", root)
    return root


def git(*arguments: str, at: Path) -> str:
    """What git says."""
    command = ["git", "-C", str(at), *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def test_a_commit_is_checked_out_and_gone_afterwards(repository):
    """The checkout itself stays as it is."""
    with checked_out("HEAD~1") as old:
        assert (old.root / "word.txt").read_text() == "old"
        assert (repository / "word.txt").read_text() == "new"
    assert not old.root.exists()
    assert len(git("worktree", "list", at=repository).splitlines()) == 1


def test_an_interrupt_leaves_nothing(repository):
    """As Ctrl-C does in the middle of a measurement."""

    def interrupted() -> None:
        with checked_out("HEAD~1") as old:
            places.append(old.root)
            raise KeyboardInterrupt

    places: list[Path] = []
    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert not places[0].exists()
    assert len(git("worktree", "list", at=repository).splitlines()) == 1


def test_a_commit_that_is_not_there_is_named(repository):
    """With what could be meant."""
    with pytest.raises(
        TreeError, match=r"git knows no commit 'nothing' here; name a commit, a tag"
    ):
        checked_out("nothing").__enter__()


def test_a_folder_without_git_is_told(tmp_path: Path, monkeypatch):
    """Such as an unpacked archive."""
    monkeypatch.setattr(module, "ROOT", tmp_path)
    with pytest.raises(TreeError):
        checked_out("HEAD").__enter__()


def test_the_copy_comes_first_on_the_path(monkeypatch):
    """And this checkout leaves the path that it has been put on."""
    monkeypatch.setenv("PYTHONPATH", f"/more:{ROOT}")
    old = Tree(Path("/old"), "old", (Path("/first"), Path("/old")))
    assert old.environment()["PYTHONPATH"] == "/first:/old:/more"


def test_an_editable_installation_does_not_come_before_the_copy(monkeypatch):
    """Its finder is taken out; the others stay."""
    editable = type("F", (), {"__module__": "_editable_skbc_bt_mission"})()
    other = type("F", (), {"__module__": "_distutils_hack"})()
    monkeypatch.setattr(sys, "meta_path", [editable, other])
    exec(WITHOUT_EDITABLE, {})  # noqa: S102 - what every Python of the copy runs
    assert sys.meta_path == [other]
