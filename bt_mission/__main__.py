"""``python -m bt_mission`` is ``bt-mission``."""

import atexit
import os
import signal
import sys

INTERRUPTED = 128 + signal.SIGINT


def main() -> int:
    """Run the command line; gives the exit code.

    Ctrl-C while it is loaded ends it; once it has ended, Ctrl-C no longer changes the exit code.
    """
    codes: list[int] = []
    atexit.register(_leave, codes)  # the first one, which is called last
    try:
        from bt_mission.core.memory import spare_collections  # noqa: PLC0415 - it takes a while

        spare_collections()
        from bt_mission.cli import main as run_command_line  # noqa: PLC0415 - the same

        codes.append(run_command_line())
    except KeyboardInterrupt:
        codes.append(INTERRUPTED)
    finally:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
    return codes[0]


def _leave(codes: list[int]) -> None:
    """Leave without taking libraries down one by one, where nobody in the graph could see us.

    Everything has been closed by now, and memory goes with the process. The end of Fast DDS alone
    would rest for 0.1 s. Processes that were seen say goodbye as ever.
    """
    discovery = sys.modules.get("bt_mission.core.dds.discovery")
    if not codes or discovery is None or not discovery.is_isolated():
        return
    try:
        sys.stdout.flush()
        sys.stderr.flush()
    except OSError:  # Python says so
        return
    os._exit(codes[0])


if __name__ == "__main__":
    sys.exit(main())
