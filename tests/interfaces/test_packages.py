"""The sources of the ROS packages: complete, explained, of one version."""

import re
import tomllib

import pytest

from tests.support.project import ROOT

PACKAGES = sorted(path.parent for path in (ROOT / "interfaces").glob("*/package.xml"))
DEFINITIONS = sorted(
    path
    for package in PACKAGES
    for kind in ("action", "msg", "srv")
    for path in package.glob(f"{kind}/*")
)


def _name(path):
    return path.name


@pytest.mark.parametrize("definition", DEFINITIONS, ids=_name)
def test_every_field_and_constant_has_a_comment(definition):
    """A reader of `ros2 interface show` learns what each field means, and its unit."""
    lines = definition.read_text(encoding="utf-8").splitlines()
    fields = [line for line in lines if re.match(r"\s*\w", line)]
    assert fields
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
    found = dict(re.findall(r"<(name|version|license)>(.*)</", manifest))
    assert found == {
        "name": package.name,
        "version": project["version"],
        "license": project["license"],
    }
