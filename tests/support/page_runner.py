"""A script: types the commands of a page, and writes what came of each.

Its arguments are a JSON file of steps, one for the results, and the time for all, s of wall time:
what runs then is ended, and no process is left. Calls of ``bt-mission`` without the
syntax of a shell run in a fork of this process, which imports once; all else goes to bash. What
stays (a server, a page for browsers) runs beside until the end, and its output is all that it has
said by then. It is run by the Python of an environment into which the wheel is installed, in an
empty folder.
"""

import contextlib
import json
import os
import re
import shlex
import signal
import subprocess
import sys
import tempfile
import traceback
from pathlib import Path
from typing import IO, Any

import bt_mission.sessions.stage  # noqa: F401 - what most commands import
from bt_mission.cli import main
from bt_mission.scenarios.faults.errors import ScenarioError
from bt_mission.testing.live_graph import Process

_SHELL = re.compile(r"[|&;<>$*~\\]|^\w+=")


def run(command: str) -> tuple[int, str]:
    """Run a command to its end; return its exit code and output."""
    words = shlex.split(command, comments=True)
    if words[0] == "cd":
        os.chdir(words[1])
        return 0, ""
    if words[0] == "export":
        for word in words[1:]:
            name, _, value = word.partition("=")
            os.environ[name] = value
        return 0, ""
    with tempfile.TemporaryFile() as file:
        if words[0] == "bt-mission" and not _SHELL.search(command.partition(" #")[0]):
            code = call(words[1:], file)
        else:
            shell = ["bash", "-c", command]
            code = subprocess.run(shell, stdout=file, stderr=file, check=False).returncode
        file.seek(0)
        return code, file.read().decode(errors="replace")


def call(arguments: list[str], file: IO[bytes]) -> int:
    """Call the command line in a fork of this process, its output in a file."""
    child = os.fork()
    if child:
        try:
            return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        except TimeoutError:
            os.kill(child, signal.SIGINT)
            os.waitpid(child, 0)
            raise
    for number in (1, 2):
        os.dup2(file.fileno(), number)
    sys.stdout.reconfigure(line_buffering=True)  # type: ignore[union-attr]  # as in a terminal
    code = 1
    try:
        code = main(arguments)
    except SystemExit as leave:
        code = int(leave.code or 0)
    except BaseException:  # noqa: BLE001 - it is shown, as Python does
        traceback.print_exc()
    finally:
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
        os._exit(code)


def started(command: str, until: str, file: Path) -> Process:
    """Start a command that stays; return it when it says this, or has ended."""
    process = Process(command, ["bash", "-c", f"exec {command}"], {}, file)
    with contextlib.suppress(ScenarioError):
        process.until(until)
    return process


def end(process: Process) -> None:
    """Interrupt it as Ctrl-C does, and end it where it does not."""
    if process.code is None:
        process.interrupt()
        with contextlib.suppress(ScenarioError):
            process.wait(within=20)
    process.kill()


def same(command: str, other: str) -> bool:
    """Return whether two commands are the same program, of which one terminal runs one."""
    count = 3 if command.startswith("bt-mission actions") else 2
    return command.split()[:count] == other.split()[:count]


def work(steps: list[dict[str, Any]], results: str) -> None:
    """Do all steps, and write what came of each before the next begins."""
    os.environ["PYTHONUNBUFFERED"] = "1"  # output and errors come in their order
    beside: list[Process] = []
    stays: list[tuple[Process, dict[str, Any]]] = []
    done: list[dict[str, Any]] = []
    try:
        for step in steps:
            if "text" in step:
                Path(step["file"]).parent.mkdir(parents=True, exist_ok=True)
                Path(step["file"]).write_text(step["text"], encoding="utf-8")
                continue
            code: int | None
            if step["until"] is None:
                code, output = run(step["command"])
            else:
                file = Path(f"{results}.{len(done)}")
                for each in [process for process in beside if same(process.name, step["command"])]:
                    beside.remove(each)
                    end(each)
                beside.append(started(step["command"], step["until"], file))
                code, output = beside[-1].code, beside[-1].output
            done.append({"command": step["command"], "code": code, "output": output})
            if step["until"] is not None:
                stays.append((beside[-1], done[-1]))
            Path(results).write_text(json.dumps(done), encoding="utf-8")
    finally:
        for each in reversed(beside):
            end(each)
        for process, result in stays:
            result["output"] = process.output
        Path(results).write_text(json.dumps(done), encoding="utf-8")


def time_is_up(*_: object) -> None:
    """Leave what runs."""
    raise TimeoutError


if __name__ == "__main__":
    signal.signal(signal.SIGALRM, time_is_up)
    signal.setitimer(signal.ITIMER_REAL, float(sys.argv[3]))
    work(json.loads(Path(sys.argv[1]).read_text(encoding="utf-8")), sys.argv[2])
