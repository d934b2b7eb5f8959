"""``bt-mission new``: a folder with a mission, a world, tests, and what an editor needs."""

from __future__ import annotations

import argparse
import json
import re
from collections.abc import Mapping, Sequence
from importlib.resources import files as package_files
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory

from bt_mission.base.diagnostics import quoted
from bt_mission.base.errors import BtMissionError
from bt_mission.base.files import docs_folder
from bt_mission.cli.exits import SUCCESS
from bt_mission.cli.options import confirm
from bt_mission.cli.parser import Command, Option

EPILOG = """\
examples:
  bt-mission new patrol          creates ./patrol
  cd patrol
  bt-mission run patrol
  pytest

  bt-mission new numbers --example servers   your own servers, and missions that call them
"""

TEMPLATES = {
    "README.md": "README.md",
    ".gitignore": "gitignore.txt",
    ".vscode/extensions.json": "extensions.json",
    ".vscode/settings.json": "settings.json",
    ".vscode/tasks.json": "tasks.json",
    "missions/NAME.yaml": "mission.yaml",
    "missions/scenarios/box_appears.scenario.yaml": "scenario.yaml",
    "tests/test_NAME.py": "test_mission.py.txt",
    "worlds/hall.yaml": "world.yaml",
}
"""The files of a project, by their paths in it, and what they are made from."""
NAME = re.compile(r"\bNAME\b")
"""Stands for the project's name in what files are made from, and as ``NAME`` in their paths."""

EXAMPLES: Mapping[str, Sequence[str]] = {
    "servers": (
        "adder_server.py",
        "fibonacci_server.py",
        "numbers.yaml",
        "numbers_in_simulation.yaml",
    ),
}
"""The files of tutorials (docs/tutorials/code), by the names of examples."""
_TUTORIALS = {"servers": "bring-your-own-server"}

_VALID = re.compile(r"[a-z][a-z0-9_-]{0,63}", re.ASCII | re.IGNORECASE)
_NO_NAMES = ("true", "false", "yes", "no", "on", "off", "null")
"""YAML takes these for values."""


def make_project(options: argparse.Namespace) -> int:
    """Make the folder as a whole, or not at all, and say what to do next."""
    name: str = options.name
    _refuse_name(name)
    if not options.yes:
        _ask_inside_project(name)
    example: str | None = options.example
    written = project_files(name) if example is None else example_files(example)
    try:
        folder = Path(name)
        if folder.exists() or folder.is_symlink():
            raise BtMissionError(
                f"{name} exists; give another name, or remove it first", code="BT-1103"
            )
        # Beside its place, so that it gets there in one step.
        with TemporaryDirectory(prefix=f".{name}.", dir=Path.cwd()) as unfinished:
            made = Path(unfinished) / name
            for path, text in written.items():
                file = made / path
                file.parent.mkdir(parents=True, exist_ok=True)
                file.write_text(text, encoding="utf-8")
            made.rename(folder)
    except OSError as error:
        raise BtMissionError(
            f"cannot create {name}: {error.strerror or error}", code="BT-1103"
        ) from error
    if example is None:
        _print_next_steps(name, written)
    else:
        print(
            f"{name}: the example '{example}'", *(f"  {name}/{path}" for path in written), sep="\n"
        )
        print(f"next:\n  cd {name}\n  bt-mission docs {_TUTORIALS[example]}")
    return SUCCESS


def _ask_inside_project(name: str) -> None:
    """Ask before a project is made inside another.

    Raises:
        BtMissionError: Where nobody wants it, or nobody can be asked.
    """
    here = Path.cwd()
    outer = next((folder for folder in (here, *here.parents) if _is_project(folder)), None)
    if outer is not None:
        confirm(
            f"{quoted(name)} is inside the project {outer}",
            ". Create it there?",
            otherwise="; change to another folder, or add --yes",
            refused="nothing was created",
        )


def _is_project(folder: Path) -> bool:
    return (folder / "missions").is_dir() and (folder / "mission.schema.json").is_file()


def project_files(name: str) -> Mapping[str, str]:
    """Return the files of a new project: their paths in its folder, and their texts."""
    from bt_mission.requirements.schema import mission_schema
    from bt_mission.scenarios.schema import scenario_schema

    templates = package_files("bt_mission.commands.new") / "project"
    texts = {
        path: (templates / file).read_text(encoding="utf-8") for path, file in TEMPLATES.items()
    }
    filled = {path.replace("NAME", name): NAME.sub(name, text) for path, text in texts.items()}
    schemas = {"mission": mission_schema(), "scenario": scenario_schema()}
    return filled | {
        f"{of}.schema.json": f"{json.dumps(schema, indent=2)}\n" for of, schema in schemas.items()
    }


def example_files(example: str) -> Mapping[str, str]:
    """Return the files of an example: their names and texts.

    Raises:
        BtMissionError: They are not installed.
    """
    folder = docs_folder()
    if folder is None:
        raise BtMissionError("no examples found: is the installation complete?", code="BT-101")
    code = folder / "tutorials" / "code"
    return {name: (code / name).read_text(encoding="utf-8") for name in EXAMPLES[example]}


def _refuse_name(name: str) -> None:
    """Refuse what is no name of a folder and a mission.

    Raises:
        BtMissionError: With what was expected.
    """
    expected = "expected letters, digits, '_' and '-', a letter first, 64 characters at most"
    if len(Path(name).parts) > 1 or name in (".", ".."):
        raise BtMissionError(
            f"{quoted(name)} is a path: {expected}; change to the parent folder first",
            code="BT-1103",
        )
    if name.lower() in _NO_NAMES:
        raise BtMissionError(
            f"{quoted(name)} is a value in YAML, so it cannot be the name of a mission",
            code="BT-1103",
        )
    if _VALID.fullmatch(name) is None:
        raise BtMissionError(
            f"{quoted(name)} is not a valid project name: {expected}", code="BT-1103"
        )


def _print_next_steps(name: str, written: Mapping[str, str]) -> None:
    print(f"{name}: a new project")
    for path in sorted(written):
        print(f"  {name}/{path}")
    steps = {
        f"cd {name}": "",
        f"bt-mission run {name}": "add --web for a page in a browser",
        "pip install 'bt-mission[test]'": "installs pytest",
        "pytest": "its tests",
        f"bt-mission check {name}": f"after changes to missions/{name}.yaml",
    }
    if find_spec("pytest") is not None:
        del steps["pip install 'bt-mission[test]'"]
    width = max(map(len, steps))
    print("next:")
    for command, remark in steps.items():
        print(f"  {command:<{width}}  # {remark}" if remark else f"  {command}")


COMMANDS = {
    "new": Command(
        make_project,
        "Creates a folder with a runnable mission, its world, passing tests, and the settings "
        "with which an editor completes and checks missions.",
        (
            Option("name", "name of the folder and its mission: letters, digits, _ and -"),
            Option(
                "--example",
                "write the files of an example in place of a project",
                choices=tuple(EXAMPLES),
            ),
            Option("--yes", "do not ask before creating a project inside another"),
        ),
        EPILOG,
    )
}
