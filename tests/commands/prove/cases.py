"""What the tests of all commands take from this one: see `tests/support/command_cases.py`."""

from tests.support.command_cases import InFolder

IN_FOLDER = {
    "prove": InFolder("prove m.yaml"),
}
PIPES = ("prove pipe.yaml",)
