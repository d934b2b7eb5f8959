"""What the tests of all commands take from this one: see `tests/support/command_cases.py`."""

from tests.support.command_cases import InFolder

IN_FOLDER = {
    "new": InFolder("new project"),
}
WRITERS = {
    "bt_mission/commands/new/command.py": "a folder that gets its name when it is whole",
}
