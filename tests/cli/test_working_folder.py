"""Code of the working folder runs only where a mission names it, whatever the command."""

from __future__ import annotations

import os
import shlex
import signal
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import pytest

from bt_mission.base.commands import ROWS
from bt_mission.base.python_process import python_environment, safe_processes
from bt_mission.testing.live_graph import LOCAL
from tests.support.command_cases import InFolder, named_cases
from tests.support.processes import PATIENCE_S, read_until
from tests.support.thorough import sample

pytestmark = pytest.mark.process

PROGRAM = Path(sys.executable).with_name("bt-mission")
NAMES = ("json", "yaml", "rclpy", "numpy", "mujoco", "pickle", "signal", "socket", "asyncio")
PLANTED = """\
import sys
with open({marks!r}, "a") as marks:
    marks.write(f"{{__name__}} in {{sys.orig_argv}}\\n")
raise ImportError("planted")
"""
MISSION = "mission: m\nworld: empty_arena\ntree: {turn: {angle: 5}, timeout: 20}\n"


def with_program(folder: Path) -> None:
    """Write a program in a folder of its own: beside it, it may import whatever it likes."""
    (folder / "programs").mkdir()
    (folder / "programs" / "short.py").write_text("import rclpy\nrclpy.init()\n")


OURS = {
    "run": InFolder("run m.yaml --json"),
    "play": InFolder("play programs/short.py", prepare=with_program),
    "watch": InFolder("watch --wait 0"),
    "revise": InFolder("revise nobody m.yaml"),
    "check": InFolder("check m.yaml"),
    "missions": InFolder("missions"),
    "worlds": InFolder("worlds"),
    "robots": InFolder("robots"),
    "tree": InFolder("tree m.yaml"),
    "schema": InFolder("schema"),
    "serve": InFolder("serve --web --port 0", "in a browser: "),
    "sim": InFolder("sim --world empty_arena --no-camera", "empty_arena"),
    "servers": InFolder("servers", "servers"),
    "mapper": InFolder("mapper --ros-args --log-level debug", "DEBUG"),
    "arbiter": InFolder("arbiter", "arbiter"),
    "replay": InFolder("replay run.mcap --once"),
    "report": InFolder("report run.mcap"),
    "verify": InFolder("verify run.mcap --require safe.yaml"),
    "diff": InFolder("diff run.mcap run.mcap"),
    "explain": InFolder("explain BT-203"),
    "doctor": InFolder("doctor"),
    "completion": InFolder("completion bash"),
}
LINES: Mapping[str, InFolder] = {**OURS, **named_cases("IN_FOLDER")}
"""Each command as it gets far in the folder."""


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """The recording of a short run."""
    folder = tmp_path_factory.mktemp("recorded")
    (folder / "m.yaml").write_text(MISSION)
    command = [str(PROGRAM), "run", "m.yaml", "--json", "--record", "run.mcap"]
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    return (folder / "run.mcap").read_bytes()


@pytest.fixture
def marks(tmp_path: Path, recording: bytes) -> Path:
    """A file that planted modules of the folder write to, when one is executed."""
    marks = tmp_path / "marks.txt"
    for name in NAMES:
        (tmp_path / f"{name}.py").write_text(PLANTED.format(marks=str(marks)))
    (tmp_path / "m.yaml").write_text(MISSION)
    (tmp_path / "safe.yaml").write_text("requirements: {slow: always speed < 1}\n")
    (tmp_path / "run.mcap").write_bytes(recording)
    for prepare in dict.fromkeys(each.prepare for each in LINES.values()):
        prepare(tmp_path)
    return marks


@pytest.mark.parametrize("name", sample([row.name for row in ROWS if row.help], 9, first=5))
def test_no_command_executes_a_module_beside_its_files(
    name: str, tmp_path: Path, marks: Path
) -> None:
    """Not even where an empty entry of `PYTHONPATH` stands for the folder."""
    path = os.pathsep + os.environ.get("PYTHONPATH", "")
    case = LINES[name]
    with subprocess.Popen(
        [PROGRAM, *shlex.split(case.line)],
        cwd=tmp_path,
        env=os.environ | LOCAL | {"PYTHONPATH": path},
        stdin=subprocess.PIPE if case.speak else subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=None if case.speak else subprocess.STDOUT,
        text=True,
    ) as process:
        output = ""
        try:
            if case.speak:
                case.speak(process)
            if case.serves:
                output = read_until(process, case.serves)
                case.act(output.splitlines()[-1])
                process.send_signal(signal.SIGINT)
            assert process.stdout is not None
            output += process.stdout.read()
            process.wait(PATIENCE_S)
        finally:
            process.kill()
    assert "Traceback" not in output
    assert (marks.read_text() if marks.exists() else "") == "", output


def test_the_folder_is_on_the_path_where_somebody_named_it() -> None:
    """Empty entries are left out, others stay."""
    path = os.pathsep.join(("", "/a", "", "/b"))
    assert python_environment({"PYTHONPATH": path})["PYTHONPATH"] == f"/a{os.pathsep}/b"
    assert "PYTHONPATH" not in python_environment({"PYTHONPATH": os.pathsep})


def test_processes_of_libraries_are_safe_for_a_while(monkeypatch: pytest.MonkeyPatch) -> None:
    """Afterwards the environment is as before, also that of the processes themselves."""
    monkeypatch.delenv("PYTHONSAFEPATH", raising=False)
    before = dict(os.environ)
    with safe_processes() as variables:
        assert os.environ["PYTHONSAFEPATH"] == "1"
        assert variables == {"PYTHONSAFEPATH": ""}
    assert dict(os.environ) == before
