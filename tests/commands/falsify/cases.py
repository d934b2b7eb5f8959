"""What the tests of all commands take from this one: see `tests/support/command_cases.py`."""

from tests.support.command_cases import InFolder

IN_FOLDER = {
    "falsify": InFolder("falsify m.yaml --budget 2 --workers 2"),
}
PIPES = ("falsify square --within pipe.yaml",)
SHORTER_ON_PAGES = {
    "--keep-going 3": "--keep-going 2 --budget 20",
    "falsify explore": "falsify explore --set legs=1 --budget 4",
}
