"""What the tests of all commands take from this one: see `tests/support/command_cases.py`."""

from tests.support.command_cases import InFolder

IN_FOLDER = {
    "fork": InFolder("fork run.mcap --at 0.2"),
}
PIPES = ("fork pipe.mcap --at 1",)
NAMES_IN_RECORDINGS = ("fork --robot NAME",)
