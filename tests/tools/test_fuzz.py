"""`tools/fuzz.py` finds nothing in the product, and whatever is planted in it."""

import gc
import json
import os
import runpy
import shutil
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace

import pytest

from action_servers.core.pilot import Pilot
from bt_mission.base.diagnostics import Diagnostic
from bt_mission.executive.behaviours import leaves
from bt_mission.executive.executive import Executive
from bt_mission.executive.goals.ledger import Ledger
from bt_mission.language.checks import scope
from bt_mission.recording.reading import RecordedFile
from bt_mission.sessions import check
from tests.support.fuzz import cases
from tests.support.fuzz.limits import MEMORY_MB, forget_peak, judge_within, peak_mb, resident_mb
from tests.support.fuzz.targets import MODULES, OF_COMMANDS, target, target_of
from tests.support.project import ROOT
from tests.support.thorough import sample

TOOL = ROOT / "tools/fuzz.py"
FOUND = cases.CORPUS / "found"
SOUND = sorted(cases.CORPUS.glob("*.yaml"))


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with what missions of the corpus include and import."""
    monkeypatch.chdir(tmp_path)
    cases.prepare(tmp_path)
    return tmp_path


def judged(text, **options):
    """Return the verdict on a mission in the working folder."""
    path = Path("m.yaml")
    path.write_text(text, encoding="utf-8")
    return judge_within(path, **options)


def fuzz(*arguments, **environ):
    """Run the tool; gives its exit code and its output."""
    done = subprocess.run(
        [sys.executable, str(TOOL), "--processes", "1", *map(str, arguments)],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, **{name: str(value) for name, value in environ.items()}},
    )
    return done.returncode, done.stdout + done.stderr


@pytest.mark.parametrize("path", SOUND, ids=lambda path: path.stem)
def test_missions_of_the_corpus_are_sound(path, folder):
    """Only then do their mutants get beyond the check."""
    verdict = judged(path.read_text(encoding="utf-8"))
    assert (verdict.accepted, verdict.finding) == (True, None)


@pytest.mark.parametrize(
    "path", sorted((*FOUND.glob("*.yaml"), *FOUND.glob("*.xml"))), ids=lambda path: path.name
)
def test_what_was_found_once_is_refused_for_good(path, folder):
    """What its author is told stands beside each."""
    file = Path(f"m{path.suffix}")
    shutil.copy(path, file)
    _, faults = check.examine(file)
    expected = path.with_suffix(".txt").read_text(encoding="utf-8")
    assert "".join(f"{fault}\n" for fault in faults) == expected
    assert judge_within(file).finding is None


@pytest.mark.thorough
@pytest.mark.process
def test_nothing_is_found_in_some_hundred_cases(tmp_path):
    """CI goes on for a minute; many of the mutants are sound, and run."""
    code, output = fuzz("--count", 400, "--save", tmp_path / "found")
    summary = json.loads(output.splitlines()[-1])
    assert (code, summary["cases"], summary["findings"]) == (0, 400, {})
    assert summary["sound"] > 40
    first, *_, last, _ = output.splitlines()
    assert first == "Judging 400 mutated missions (seed 1, processes: 1)"
    assert last == "Found nothing."
    assert not (tmp_path / "found").exists()


@pytest.mark.thorough
@pytest.mark.process
def test_a_hunt_goes_on_where_it_ended(tmp_path):
    """With the counts of before; not with another seed."""
    state = tmp_path / "state.json"
    arguments = ("--target", "goals", "--save", tmp_path / "found", "--state", state)
    code, output = fuzz("--count", 10, *arguments)
    summary = json.loads(output.splitlines()[-1])
    assert (code, summary["cases"], summary["findings"]) == (0, 10, {})
    assert summary["inputs"] > 10
    assert json.loads(state.read_text())["first"] == 10
    code, output = fuzz("--count", 5, *arguments)
    assert (code, json.loads(output.splitlines()[-1])["cases"]) == (0, 15)
    code, output = fuzz("--seconds", 1, *arguments)
    assert (code, json.loads(output.splitlines()[-1])["cases"] > 15) == (0, True)
    code, output = fuzz("--count", 1, "--seed", 2, *arguments)
    assert code == 2
    assert output.splitlines()[-1] == f"fuzz.py: {state} is of another target or another seed"


@pytest.mark.parametrize("name", sample([name for name in MODULES if name != "missions"], 3))
def test_nothing_is_found_in_some_cases_of_each_other_target(name, folder):
    """Some are sound, so that what is behind the first check is reached."""
    chosen = target(name)
    if name == "controls":
        chosen.prepare(Path())
    result = chosen.corpus()
    verdicts = []
    for number in range(25):
        case = chosen.case(result, 1, number)
        Path(case.name).write_bytes(case.contents)
        verdicts.append(judge_within(Path(case.name), judge=chosen.judge))
    assert [verdict.finding for verdict in verdicts if verdict.finding is not None] == []
    assert any(verdict.accepted for verdict in verdicts)


@pytest.mark.usefixtures("folder")  # the corpus of some is files, which are written
@pytest.mark.parametrize("name", sample(MODULES, 3))
def test_a_case_of_each_target_follows_from_the_seed_and_its_number(name):
    """And its suffix leads back to its target."""
    chosen = target(name)
    result = chosen.corpus()
    cases_of = [chosen.case(result, 1, number) for number in range(10)]
    assert chosen.case(result, 1, 9) == cases_of[-1]
    assert chosen.case(result, 2, 9) != cases_of[-1]
    assert len({case.contents for case in cases_of}) > 8
    if name not in OF_COMMANDS:  # whose files may be missions, too
        assert {target_of(Path(case.name)) for case in cases_of} == {name}


def judged_sample(name, contents=None, number=0, **options):
    """Judge a sound case of a target, or another one of its kind."""
    chosen = target(name)
    samples = list(chosen.samples(chosen.corpus()))
    path = Path(samples[number].name)
    path.write_bytes(samples[number].contents if contents is None else contents)
    return judge_within(path, judge=chosen.judge, **options)


def crash(*_args, **_kwargs):
    """Raise what nobody expects."""
    raise KeyError("planted")


@pytest.mark.parametrize(
    ("name", "where", "planted", "kind"),
    [
        ("recordings", (RecordedFile, "facts"), property(crash), "KeyError in test_fuzz.py:crash"),
        ("goals", (Ledger, "is_settled"), False, "the mission does not end"),
        ("controls", (Executive, "interrupt"), lambda *_: None, "the mission does not end"),
        ("servers", (Pilot, "_end_all"), lambda *_: None, "a maneuver goes on after a stop"),
        *((name, *import_module(module).PLANTED) for name, module in OF_COMMANDS.items()),
    ],
)
def test_a_fault_planted_behind_another_target_is_found(
    name, where, planted, kind, folder, monkeypatch
):
    """Whichever of its samples it is that meets the fault."""
    count = len(list(target(name).samples(target(name).corpus())))
    if name == "controls":
        target(name).prepare(Path())
    monkeypatch.setattr(*where, planted)
    verdicts = (judged_sample(name, number=number) for number in range(min(count, 20)))
    assert any(
        verdict.finding.kind.startswith(kind) for verdict in verdicts if verdict.finding is not None
    )


def test_a_damaged_recording_that_says_nothing_is_a_finding(folder, monkeypatch):
    """A cut one that ends before its end, and nobody tells."""
    chosen = target("recordings")
    whole = next(iter(chosen.samples(chosen.corpus()))).contents
    for share in (0.5, 0.7, 0.9):
        assert judged_sample("recordings", whole[: int(share * len(whole))]).finding is None
    monkeypatch.setattr(RecordedFile, "_note_cut", lambda *_: None)
    results = [
        judged_sample("recordings", whole[: int(share * len(whole))]).finding
        for share in (0.5, 0.7, 0.9)
    ]
    assert "taken for whole: damaged" in {result.kind for result in results if result is not None}


@pytest.mark.thorough
@pytest.mark.process
@pytest.mark.parametrize(
    ("update", "kind"),
    sample(
        [
            ("1 / 0", "ZeroDivisionError in bad_leaf.py:update"),
            ("signal.pause()", "a hang"),
            ("os.kill(os.getpid(), signal.SIGSEGV)", "the process ended with -11"),
            (f"len('x' * {(MEMORY_MB + 30) * 2**20})", f"more than {MEMORY_MB} MB"),
            (f"len('x' * {3 * MEMORY_MB * 2**20})", "MemoryError in bad_leaf.py:update"),
        ],
        every=9,
    ),
)
def test_a_finding_is_told_and_can_be_repeated(update, kind, tmp_path):
    """A leaf of somebody's that raises, takes too much or never returns stands for our bugs."""
    leaf = (
        "import os, signal\n"
        "from py_trees.behaviour import Behaviour\n"
        "from py_trees.common import Status\n"
        "class Bad(Behaviour):\n"
        "    def update(self):\n"
        f"        {update}\n"
        "        return Status.SUCCESS\n"
    )
    (tmp_path / "bad_leaf.py").write_text(leaf, encoding="utf-8")
    path = tmp_path / "case.yaml"
    path.write_text("mission: m\ntree: {python: 'bad_leaf:Bad'}\n", encoding="utf-8")
    code, output = fuzz("--replay", path, "--patience", 1, PYTHONPATH=tmp_path)
    assert code == 1
    assert f"FOUND: {kind}\n" in output
    assert output.splitlines()[0] == "Judging 1 file"
    assert output.splitlines()[-2] == "Found 1 kind of faults in the project."


def test_a_case_is_judged_by_the_memory_that_it_takes_itself(folder, monkeypatch):
    """A process that had more before sees it nevertheless, and blames nobody for what it had."""
    before = "x" * (2 * MEMORY_MB * 2**20)
    assert peak_mb() > 2 * MEMORY_MB
    del before
    gc.collect()  # what other tests have left would be given back while the case is judged
    forget_peak()
    if peak_mb() > resident_mb() + MEMORY_MB:
        pytest.skip("the kernel does not let the peak be reset")
    text = "mission: m\ntree: {wait: 1}\n"
    assert judged(text).finding is None
    monkeypatch.setattr(scope, "_naming_diagnostics", grow)
    finding = judged(text).finding
    assert finding is not None
    assert finding.kind == f"more than {MEMORY_MB} MB"


@pytest.mark.process
@pytest.mark.parametrize(
    ("arguments", "lines"),
    [
        (["--processes", 0], "argument --processes: invalid whole number from 1 value: '0'"),
        (["--replay", "nobody.yaml"], "argument --replay: no file 'nobody.yaml'"),
        (["--count", 1], "fuzz.py: a process ended with 1 before its first case"),
    ],
)
def test_a_hunt_that_cannot_be_is_no_finding(arguments, lines, tmp_path):
    """Nor is it a success; without py_trees, say, nothing can be judged."""
    (tmp_path / "py_trees.py").write_text("raise ImportError\n", encoding="utf-8")
    code, output = fuzz(*arguments, PYTHONPATH=tmp_path)
    assert code == 2
    assert output.splitlines()[-1].endswith(lines)


def test_a_finding_is_saved(tmp_path, capsys):
    """The first of each kind, with the line that repeats it."""
    tool = runpy.run_path(str(TOOL))
    options = {"target": "missions", "seed": 5, "save": tmp_path / "found", "replay": None}
    hunt = tool["Hunt"](SimpleNamespace(**options))
    worker = SimpleNamespace(number=17, name="m.yaml")
    hunt.note(worker, "KeyError in scope.py", "where it was", b"mission: m\n")
    hunt.note(worker, "KeyError in scope.py", "where it was", b"mission: n\n")
    path = tmp_path / "found" / "missions_5_17.yaml"
    assert path.read_bytes() == b"mission: m\n"
    assert path.with_suffix(".txt").read_text() == "KeyError in scope.py\nwhere it was\n"
    assert hunt.findings == {"KeyError in scope.py": 2}
    assert capsys.readouterr().out.splitlines() == [
        "",
        "FOUND: KeyError in scope.py",
        "where it was",
        f"repeat it: python tools/fuzz.py --replay {path}",
    ]


def hang(*_args, **_kwargs):
    """Never come back."""
    while True:
        pass


def grow(*_args, **_kwargs):
    """Take more than there is."""
    return iter(("x" * (MEMORY_MB + 100) * 2**20)[:0])


def look_away(*_args, **_kwargs):
    """See nothing wrong."""
    return iter(())


def misplace(*_args, **_kwargs):
    """See something wrong, and not say where."""
    return iter([Diagnostic("BT-100", "planted", "m.yaml")])


@pytest.mark.parametrize(
    ("where", "planted", "kind"),
    [
        ((scope, "_naming_diagnostics"), crash, "KeyError in test_fuzz.py:crash"),
        ((scope, "_naming_diagnostics"), hang, "more than 0.5 s of the processor"),
        ((scope, "_naming_diagnostics"), misplace, "a fault without a place"),
        ((scope, "number_diagnostics"), look_away, "all values are known, wait"),
        ((scope, "evaluate_constants"), look_away, "known beforehand, log"),
        ((scope, "reference_diagnostics"), look_away, "a name that is not known, log"),
        ((leaves.Wait, "update"), crash, "KeyError in test_fuzz.py:crash"),
        ((Ledger, "is_settled"), False, "the mission does not end"),
    ],
)
def test_a_planted_fault_is_found(where, planted, kind, folder, monkeypatch):
    """In the check, in a leaf, or where the check does not see what it ought to."""
    nodes = {
        "number_diagnostics": "{wait: n - 3}",
        "evaluate_constants": "{log: '${1 / (n - 2)}'}",
        "reference_diagnostics": "{log: '$n $nobody'}",
    }
    node = nodes.get(where[1], "{wait: n}")
    text = f"mission: m\ninputs: {{n: 2}}\ntree: {{sequence: [{node}, {{log: $n}}]}}\n"
    assert judged(text).finding is None
    monkeypatch.setattr(*where, planted)
    finding = judged(text, cpu_s=0.5).finding
    assert finding is not None
    assert finding.kind == kind
