"""``python -m bt_mission`` is ``bt-mission``."""

import signal
import sys

INTERRUPTED = 128 + signal.SIGINT


def main() -> int:
    """Run the command line; gives the exit code, also where Ctrl-C comes while it is loaded."""
    try:
        from bt_mission.cli import main as run_command_line  # noqa: PLC0415 - it takes a while

        return run_command_line()
    except KeyboardInterrupt:
        return INTERRUPTED


if __name__ == "__main__":
    sys.exit(main())
