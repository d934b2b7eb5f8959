"""What the tests of all commands take from this one: see `tests/support/command_cases.py`."""

from tests.support.command_cases import InFolder

IN_FOLDER = {
    "convert": InFolder("convert m.yaml"),
}
PIPES = ("convert pipe.yaml", "convert pipe.xml")
OUTPUTS = (("convert m.yaml -o", "m.xml"), ("convert --palette -o", "palette.xml"))
HELP = ("convert",)
FILES_THAT_ARE_NOT_THERE = ("convert",)
COMPLETED_FILES = ("own/mine.xml",)
