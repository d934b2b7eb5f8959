"""Starts scripts from a process that has imported the libraries already: for the smoke alone.

Most of a tiny run are imports, a second and a half each. Here they are done once, and each script
begins in a fork of this process: with its own folder, variables, output and process group, in a
main module that is empty, since this one is imported. Requests come as lines of JSON on standard
input, answers go to standard output: who has started, and how it has ended.
"""

from __future__ import annotations

import atexit
import importlib
import json
import os
import selectors
import signal
import sys
import traceback
from pathlib import Path
from typing import Any, NoReturn

LIBRARIES = (
    "bt_mission.sessions.stage",
    "bt_mission.sessions.check",
    "bt_mission.recording.writer",
    "bt_mission.testing.stages",
)
"""What most benchmarks import. One that is not there is left to the scripts to complain of."""


def main() -> None:
    """Serve requests until there are no more; in a fork, be the script."""
    for name in LIBRARIES:
        try:
            importlib.import_module(name)
        except ImportError:
            continue
    waiting = selectors.DefaultSelector()
    waiting.register(sys.stdin, selectors.EVENT_READ)
    pids: dict[int, tuple[int, int]] = {}
    while True:
        for key, _ in waiting.select():
            if key.fd in pids:
                number, pid = pids.pop(key.fd)
                waiting.unregister(key.fd)
                os.close(key.fd)
                _, status = os.waitpid(pid, 0)
                _answer(number=number, code=os.waitstatus_to_exitcode(status))
                continue
            line = os.read(sys.stdin.fileno(), 1 << 20)
            if not line:
                return
            request = json.loads(line)
            pid = os.fork()
            if pid == 0:
                waiting.close()
                _become(request)
            descriptor = os.pidfd_open(pid)
            pids[descriptor] = (request["number"], pid)
            waiting.register(descriptor, selectors.EVENT_READ)
            _answer(number=request["number"], pid=pid)


def _answer(**record: int) -> None:
    sys.stdout.write(json.dumps(record) + "\n")
    sys.stdout.flush()


def _become(request: dict[str, Any]) -> NoReturn:
    """Carry a script out as if Python had been started with it.

    It ends without taking the interpreter down, which ROS does not survive where it was imported
    before the fork.
    """
    os.setsid()
    signal.signal(signal.SIGINT, signal.default_int_handler)
    os.chdir(request["folder"])
    os.environ.clear()
    os.environ.update(request["environment"])
    nothing = os.open(os.devnull, os.O_RDONLY)
    output = os.open(request["output"], os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    os.dup2(nothing, 0)
    os.dup2(output, 1)
    os.dup2(output, 2)
    sys.argv = request["command"]
    sys.path[0] = str(Path(sys.argv[0]).parent)
    space = sys.modules["__main__"].__dict__
    space["__file__"] = sys.argv[0]
    code = 0
    try:
        source = Path(sys.argv[0]).read_text(encoding="utf-8")
        exec(compile(source, sys.argv[0], "exec"), space)  # noqa: S102 - our own script
    except SystemExit as error:
        if isinstance(error.code, str):
            print(error.code, file=sys.stderr)
        code = error.code if isinstance(error.code, int) else int(error.code is not None)
    except BaseException:  # noqa: BLE001 - told and answered as Python itself does
        traceback.print_exc()
        code = 1
    atexit._run_exitfuncs()  # noqa: SLF001 - the only way to what os._exit leaves out
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)
