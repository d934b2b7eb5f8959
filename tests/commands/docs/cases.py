"""What the tests of all commands take from this one: see `tests/support/command_cases.py`."""

from tests.support.command_cases import InFolder

IN_FOLDER = {
    "docs": InFolder("docs seeds"),
}
COMPLETED = (
    (["docs", "real"], ["real-robot"]),
    (["docs", "fleet", "how-to/"], ["how-to/requirements"]),
)
