"""Each command can be taken away: without its folder everything else works as before."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from bt_mission.base.commands import FOLDER, ROWS, CommandRow, row_of
from tests.support.project import ROOT
from tests.support.thorough import sample

FOLDERS = sorted({row.folder for row in ROWS})
"""The folders and files below ``bt_mission/commands``."""

FILES = {
    "m.yaml": "mission: m\nworld: empty_arena\ntree:\n  wait: 0.2\n",
    "s.scenario.yaml": "scenario: s\nmission: m.yaml\n",
    "f.fleet.yaml": "fleet: f\nworld: empty_arena\nrobots: {a: {mission: m.yaml, at: [0, 0]}}\n",
    "w.yaml": "name: w\nsize: [4, 4]\n",
    "q.yaml": "requirements:\n  slow: always speed < 9\n",
    "g.yaml": "seeds: 3\n",
    "t.xml": '<root BTCPP_format="4"><BehaviorTree ID="t"><wait/></BehaviorTree></root>',
    "test_m.py": "def test_m(stage):\n    assert stage.run('m.yaml').until_done().passed\n",
}
RECORDING = ROOT / "tests/fuzz/corpus/recordings/square.mcap"
LINES: dict[str, tuple[str, ...]] = {
    "--help": (),
    "check m.yaml": (f"{FOLDER}.check",),
    "check s.scenario.yaml f.fleet.yaml w.yaml q.yaml g.yaml": (f"{FOLDER}.check",),
    "check t.xml": (f"{FOLDER}.check", f"{FOLDER}.convert"),
    "run m.yaml --json": (f"{FOLDER}.run",),
    f"replay {RECORDING} --once --at 2": (f"{FOLDER}.replay",),
}
"""Lines, and the folders that each cannot do without."""

PROGRAM = """\
import contextlib, importlib.abc, io, json, sys
sys.path[:0] = PATH
class Blocked(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if FOLDER and (name == FOLDER or name.startswith(FOLDER + ".")):
            raise ModuleNotFoundError(f"no module named {name!r}", name=name)
sys.meta_path.insert(0, Blocked())
import pytest
from bt_mission.cli import main
told = {}
for line in LINES:
    out = io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(out):
        try:
            code = main(line.split())
        except SystemExit as end:
            code = end.code
    told[line] = [code, out.getvalue()]
with contextlib.redirect_stdout(io.StringIO()):
    told["pytest"] = [int(pytest.main(["-q", "-p", "no:cacheprovider", "test_m.py"])), ""]
print(json.dumps(told))
"""


def outputs_without(folder: str, where: Path, lines: list[str]) -> dict[str, Any]:
    """The exit code and the output of each line, in a process that cannot import a folder."""
    for name, text in FILES.items():
        (where / name).write_text(text, encoding="utf-8")
    program = PROGRAM.replace("PATH", repr(sys.path)).replace("LINES", repr(lines))
    done = subprocess.run(
        [sys.executable, "-c", program.replace("FOLDER", repr(folder))],
        cwd=where,
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | {"COLUMNS": "100"},
    )
    assert done.returncode == 0, done.stderr
    outputs: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    for line, (_, text) in outputs.items():
        outputs[line][1] = [each for each in text.splitlines() if "wall" not in each]
    return outputs


@cache
def outputs_with_all(where: Path) -> dict[str, Any]:
    """The same with every folder."""
    return outputs_without("", where, list(LINES))


@pytest.fixture(scope="session")
def complete(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """What every line prints where nothing is taken away."""
    return outputs_with_all(tmp_path_factory.mktemp("complete"))


def absent_without(folder: str) -> list[CommandRow]:
    """The rows that go with a folder: its own, and those that need it."""
    gone = {row.name for row in ROWS if row.folder == folder}
    while more := {row.name for row in ROWS if gone & {*row.needs}} - gone:
        gone |= more
    return [row_of(name) for name in sorted(gone)]


@pytest.mark.process(always=True)
@pytest.mark.parametrize("folder", sample(FOLDERS, len(FOLDERS)))
def test_everything_else_works_without_a_folder(
    folder: str, tmp_path: Path, complete: dict[str, Any]
) -> None:
    """Nothing is different but the list of commands, and a line says what is absent."""
    gone = [row for row in absent_without(folder) if row.help]
    lines = [line for line, needed in LINES.items() if folder not in needed]
    outputs = outputs_without(folder, tmp_path, [*lines, *(row.name for row in gone)])
    (code, listed), (_, all_listed) = outputs.pop("--help"), complete["--help"]
    assert code == 0
    words = {line.split()[0] for line in listed if line.startswith("    ") and line[4] != " "}
    known = {line.split()[0] for line in all_listed if line.startswith("    ") and line[4] != " "}
    assert known - words == {row.name for row in gone}
    for row in gone:
        code, text = outputs.pop(row.name)
        assert code == 2
        assert text[0].startswith(f"'{row.name}' is not part of this installation: ")
        assert f"{folder} is absent" in text[0]
    if f"{FOLDER}.run" == folder:
        del outputs["pytest"]
    assert outputs == {line: complete[line] for line in outputs}
