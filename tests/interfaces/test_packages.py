"""The sources of the ROS packages: complete, explained, of one version."""

import importlib
import re
import sys
import sysconfig
import tomllib
from pathlib import Path

import pytest

from tests.support.project import ROOT

PACKAGES = sorted(path.parent for path in (ROOT / "interfaces").glob("*/package.xml"))
DEFINITIONS = sorted(
    path
    for package in PACKAGES
    for kind in ("action", "msg", "srv")
    for path in package.glob(f"{kind}/*")
)


AS_PUBLISHED = {"control_msgs": "BSD-3-Clause"}
"""Packages whose files are copies of the published ones, with their licences."""


def _name(path):
    return path.name


@pytest.mark.parametrize("definition", DEFINITIONS, ids=_name)
def test_every_field_and_constant_has_a_comment(definition):
    """A reader of `ros2 interface show` learns what each field means, and its unit."""
    lines = definition.read_text(encoding="utf-8").splitlines()
    fields = [line for line in lines if re.match(r"\s*\w", line)]
    assert fields or definition.stem == "Empty"
    if definition.parents[1].name in AS_PUBLISHED:
        return
    assert [line for line in fields if not re.search(r"#\s+\S", line)] == []


@pytest.mark.parametrize("package", PACKAGES, ids=_name)
def test_every_definition_is_built(package):
    """CMakeLists.txt names exactly the files that are there."""
    built = re.findall(
        r'"((?:action|msg|srv)/\w+\.\w+)"', (package / "CMakeLists.txt").read_text(encoding="utf-8")
    )
    there = [
        path.relative_to(package).as_posix() for path in DEFINITIONS if package in path.parents
    ]
    assert sorted(built) == there


@pytest.mark.parametrize("package", PACKAGES, ids=_name)
def test_package_and_project_have_one_version(package):
    """The same thing has the same number, whether pip or colcon builds it."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    manifest = (package / "package.xml").read_text(encoding="utf-8")
    result = dict(re.findall(r"<(name|version|license)>(.*)</", manifest))
    assert result == {
        "name": package.name,
        "version": project["version"],
        "license": AS_PUBLISHED.get(package.name, project["license"]),
    }


SUBSTITUTES = [
    "control_msgs",
    "example_interfaces",
    "nav2_msgs",
    "simulation_interfaces",
    "tf2_msgs",
]


@pytest.mark.parametrize("package", SUBSTITUTES)
def test_a_substitute_lies_where_python_looks_last(package):
    """So that it neither overwrites nor hides a real package, whichever was installed first."""
    place = Path(importlib.import_module(package).__file__ or "").parents[1]
    real = Path(sysconfig.get_path("purelib"))
    assert place == Path(sys.prefix, "share/bt_mission/ros", real.relative_to(sys.prefix))
    assert sys.path.index(str(real)) < [str(Path(folder).resolve()) for folder in sys.path].index(
        str(place.resolve())
    )
