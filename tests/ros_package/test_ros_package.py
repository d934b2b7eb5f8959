"""The package for colcon and its launch files, held against what the product is and takes.

The launch system itself is not on PyPI. What can be told without it is that each command line that
a launch file makes is one that `bt-mission` takes.
"""

from __future__ import annotations

import ast
import re
import tomllib
from collections.abc import Iterator
from configparser import ConfigParser
from pathlib import Path
from typing import get_args
from xml.etree import ElementTree as ET

import pytest

from bt_mission.base.files import Kind, folders
from bt_mission.cli import ros_arguments
from bt_mission.cli.main import make_parser
from bt_mission.cli.subparsers import load_commands
from tests.support.project import ROOT

PACKAGE = ROOT / "ros_package"


def _root(path: Path) -> ET.Element:
    return ET.parse(path).getroot()  # noqa: S314 - our own file


LAUNCH_FILES = sorted((PACKAGE / "launch").iterdir())
MANIFEST = _root(PACKAGE / "package.xml")
NAMES = [path.name.removesuffix(".launch.xml") for path in LAUNCH_FILES]
GIVEN = {"mission": "square"}
"""Values of arguments that have no default."""


def _arguments(path: Path) -> dict[str, str]:
    """What a launch file declares, with its defaults."""
    declared = _root(path).iter("arg")
    return {str(arg.get("name")): arg.get("default", "") for arg in declared} | {
        name: value for name, value in GIVEN.items() if f'name="{name}"' in path.read_text()
    }


def _resolved(text: str, arguments: dict[str, str]) -> str:
    """The substitutions of the launch system that are used here, carried out."""
    for _ in range(3):  # a default may name another argument
        text = re.sub(r"\$\(var (\w+)\)", lambda result: arguments[result[1]], text)
        text = re.sub(r"\$\(env \w+ (\w+)\)", r"\1", text)
    return text.replace("$(find-pkg-share bt_mission)", str(ROOT))


def _command_lines(path: Path) -> Iterator[list[str]]:
    """The arguments of each process of a launch file, as `launch` divides them: at blanks."""
    arguments = _arguments(path)
    for action in _root(path):
        written = action.get("args") or action.get("cmd")
        if written is None:
            continue
        # A value stays one argument, also an empty one: it is put in after the text is divided.
        parts = re.findall(r"(?:\$\([^)]*\)|\S)+", written)
        yield [_resolved(part, arguments) for part in parts if "exec-in-pkg" not in part]


@pytest.mark.parametrize("path", LAUNCH_FILES, ids=NAMES)
def test_each_process_of_a_launch_file_is_a_command_that_there_is(path: Path) -> None:
    """With options that the command takes, and ROS arguments only where it takes them."""
    parser = make_parser()
    load_commands(parser)
    for action in _root(path):
        if action.tag == "node":
            assert (action.get("pkg"), action.get("exec")) == ("bt_mission", "bt-mission")
    for line in _command_lines(path):
        options = parser.parse_args(line)
        is_node = f'args="{line[0]} ' in path.read_text()
        assert is_node == getattr(options, "takes_ros_args", False)


@pytest.mark.parametrize("path", LAUNCH_FILES, ids=NAMES)
def test_each_argument_is_described_and_each_file_included_is_there(path: Path) -> None:
    """`ros2 launch --show-args` teaches; an included file finds its arguments by their names."""
    tree = _root(path)
    assert all(arg.get("description") for arg in tree.iter("arg"))
    for include in tree.iter("include"):
        included = PACKAGE / "launch" / Path(str(include.get("file"))).name
        assert included in LAUNCH_FILES
        inner = _arguments(included)
        mine = _arguments(path)
        assert {name: inner[name] for name in inner.keys() & mine.keys()} == {
            name: mine[name] for name in inner.keys() & mine.keys()
        }


def test_the_package_is_the_one_that_pip_installs() -> None:
    """Version, licence, entry points and data are those of pyproject.toml and of the product."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert MANIFEST.findtext("version") == project["version"]
    assert MANIFEST.findtext("license") == project["license"]
    assert MANIFEST.findtext("name") == project["name"].replace("-", "_")
    config = ConfigParser()
    config.read(PACKAGE / "setup.cfg")
    written = config["options.entry_points"]["pytest11"].split("=")
    assert {written[0].strip(): written[1].strip()} == project["entry-points"]["pytest11"]
    installed = (PACKAGE / "CMakeLists.txt").read_text(encoding="utf-8")
    match = re.search(r"foreach\(folder ([\w ]+)\)", installed)
    assert match is not None
    assert set(match[1].split()) == set(get_args(Kind))


@pytest.mark.parametrize("extra", [None, "dev"], ids=["run", "test"])
def test_what_pip_installs_beside_ros_is_what_the_project_needs(extra: str | None) -> None:
    """Each dependency but ROS itself."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    needed = project["optional-dependencies"][extra] if extra else project["dependencies"]
    name = "requirements-test.txt" if extra else "requirements.txt"
    lines = (PACKAGE / name).read_text(encoding="utf-8").splitlines()
    assert lines[1:] == [each for each in needed if not each.startswith("ros-")]


@pytest.mark.thorough
def test_the_manifest_names_each_ros_package_that_is_imported() -> None:
    """So `rosdep` installs them all."""
    named = {each.text for each in MANIFEST.iter("exec_depend")}
    assert _imported_packages() - named == set()


def _imported_packages() -> set[str]:
    """Packages of ROS interfaces that the product imports."""
    packages = set()
    for folder in ("bt_mission", "action_servers", "sim"):
        for path in (ROOT / folder).rglob("*.py"):
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                if isinstance(node, ast.ImportFrom) and node.module:
                    package, _, kind = node.module.partition(".")
                    if kind in {"msg", "srv", "action"}:
                        packages.add(package)
    return packages


def test_files_of_a_sourced_workspace_are_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """After the working folder and the sources, in the order in which ROS looks."""
    first, second = tmp_path / "first", tmp_path / "second"
    monkeypatch.setenv("AMENT_PREFIX_PATH", f"{first}::{second}")
    shares = [path for path in folders("worlds") if path.is_relative_to(tmp_path)]
    assert shares == [first / "share/bt_mission/worlds", second / "share/bt_mission/worlds"]


def test_ros_arguments_of_a_launched_node_are_taken() -> None:
    """What `launch_ros` appends to a node in a namespace."""
    mine, for_ros = ros_arguments.split(["sim", "--ros-args", "-r", "__ns:=/tb3"])
    assert (mine, for_ros) == (["sim"], ["-r", "__ns:=/tb3"])
