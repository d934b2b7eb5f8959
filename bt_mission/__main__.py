"""``python -m bt_mission`` is ``bt-mission``."""

import signal
import sys

INTERRUPTED = 128 + signal.SIGINT


def main() -> int:
    """Run the command line; gives the exit code.

    Ctrl-C while it is loaded ends it; once it has ended, Ctrl-C no longer changes the exit code.
    """
    try:
        from bt_mission.core.memory import spare_collections  # noqa: PLC0415 - it takes a while

        spare_collections()
        from bt_mission.cli import main as run_command_line  # noqa: PLC0415 - the same

        return run_command_line()
    except KeyboardInterrupt:
        return INTERRUPTED
    finally:
        signal.signal(signal.SIGINT, signal.SIG_IGN)


if __name__ == "__main__":
    sys.exit(main())
