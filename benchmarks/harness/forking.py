"""Scripts of the smoke are forks of one process that has imported what most of them need.

A start of Python with ROS, NumPy and MuJoCo costs more than what the smoke of a script does.
"""

from __future__ import annotations

import asyncio
import gc
import os
import signal
import sys
import traceback
from contextlib import suppress
from pathlib import Path
from types import ModuleType


def prepare() -> None:
    """Import what most scripts need, once, before the first of them is started."""
    import bt_mission.cli.run  # noqa: PLC0415 - only the smoke needs them
    import bt_mission.scenarios.run  # noqa: PLC0415
    import bt_mission.sessions.stage  # noqa: F401, PLC0415

    gc.freeze()


async def run_fork(
    command: list[str], folder: Path, environment: dict[str, str], output: Path
) -> int:
    """Run a script in a fork to its end, and return its exit code; kill its remaining processes."""
    process = os.fork()
    if not process:
        _become(command, folder, environment, output)
    handle, ended, loop = os.pidfd_open(process), asyncio.Event(), asyncio.get_running_loop()
    loop.add_reader(handle, ended.set)
    try:
        await ended.wait()
    finally:
        loop.remove_reader(handle)
        os.close(handle)
        code = _end(process)
    return code


def _end(process: int) -> int:
    with suppress(ProcessLookupError):
        os.killpg(process, signal.SIGKILL)
    _, status = os.waitpid(process, 0)
    return os.waitstatus_to_exitcode(status)


def _become(command: list[str], folder: Path, environment: dict[str, str], output: Path) -> None:
    """Be the process of a script: nothing of what started it is left but its imports."""
    code = 1
    try:
        os.setsid()
        signal.set_wakeup_fd(-1)
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.SIG_DFL)
        signal.signal(signal.SIGINT, signal.default_int_handler)
        os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
        file = os.open(output, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        os.dup2(file, 1)
        os.dup2(file, 2)
        os.chdir(folder)
        os.environ.clear()
        os.environ.update(environment)
        sys.argv = command
        sys.path[0] = str(Path(command[0]).parent)
        code = _exit_code(command[0])
        sys.stdout.flush()
        sys.stderr.flush()
    finally:
        os._exit(code)


def _exit_code(script: str) -> int:
    # As Python itself runs a file; a script's own processes find their functions in it.
    module = ModuleType("__main__")
    module.__file__ = script
    sys.modules["__main__"] = sys.modules["__mp_main__"] = module
    try:
        exec(compile(Path(script).read_bytes(), script, "exec"), module.__dict__)  # noqa: S102
    except SystemExit as end:
        if isinstance(end.code, str):
            print(end.code, file=sys.stderr)
            return 1
        return end.code or 0
    except BaseException:  # noqa: BLE001 - as Python itself ends
        traceback.print_exc()
        return 1
    return 0
