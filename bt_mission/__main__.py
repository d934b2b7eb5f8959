"""``python -m bt_mission`` is ``bt-mission``."""

import atexit
import os
import sys

INTERRUPTED = 130


def main() -> int:
    """Run the command line; gives the exit code.

    Ctrl-C while it is loaded ends it; once it has ended, Ctrl-C no longer changes the exit code.
    """
    _leave_working_folder()
    # Looking for plug-ins takes pydantic as long as all else; an empty value brings them back.
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    import signal  # noqa: PLC0415 - from its own folder

    codes: list[int] = []
    atexit.register(_leave, codes)  # the first one, which is called last
    try:
        if signal.getsignal(signal.SIGINT) is signal.SIG_DFL:  # since Python started
            signal.signal(signal.SIGINT, signal.default_int_handler)
        from bt_mission.base.memory import spare_collections  # noqa: PLC0415 - it takes a while
        from bt_mission.views.terminal.streams import (  # noqa: PLC0415
            keep_output_for_python,
            open_standard_streams,
        )

        open_standard_streams()
        spare_collections()
        keep_output_for_python()
        from bt_mission.cli import main as run_command_line  # noqa: PLC0415 - the same

        codes.append(run_command_line())
    except KeyboardInterrupt:
        codes.append(INTERRUPTED)
    finally:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
    return codes[0]


def _leave_working_folder() -> None:
    """Take the working folder off the path of imports, unless somebody has named it.

    ``python -m`` puts it there, and so does an empty entry of ``PYTHONPATH``. A ``json.py`` beside
    a mission would then be executed.
    """
    spec = sys.modules["__main__"].__spec__
    is_by_name = spec is not None and not sys.flags.safe_path
    entries = os.environ.get("PYTHONPATH", "").split(os.pathsep)
    try:
        folder = os.getcwd()  # noqa: PTH109 - loads nothing
    except FileNotFoundError:
        return
    for _ in range(is_by_name + (len(entries) > 1 and "" in entries)):
        if folder in sys.path:
            sys.path.remove(folder)


def _leave(codes: list[int]) -> None:
    """Leave without taking libraries down one by one, where nobody in the graph could see us.

    Everything has been closed by now, and memory goes with the process. The end of Fast DDS alone
    would rest for 0.1 s. Processes that were seen say goodbye as ever.
    """
    discovery = sys.modules.get("bt_mission.base.dds.discovery")
    is_isolated = discovery is not None and discovery.is_isolated()
    if not codes or ("rclpy" in sys.modules and not is_isolated):
        return
    try:
        sys.stdout.flush()
        sys.stderr.flush()
    except OSError:  # Python says so
        return
    os._exit(codes[0])


if __name__ == "__main__":
    sys.exit(main())
