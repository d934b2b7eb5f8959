"""What is installed: the wheel and the source archive hold every file that the product reads."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tarfile
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import pytest

from tests.support.processes import PATIENCE_S
from tests.support.project import ROOT

pytestmark = [
    pytest.mark.process,
    pytest.mark.skipif(
        find_spec("scikit_build_core") is None or shutil.which("cmake") is None,
        reason="scikit-build-core or cmake is not installed",
    ),
]

PACKAGES = ("bt_mission", "action_servers", "sim")
DATA = ("missions", "worlds", "robots", "parameters")

BUILD = """\
import sys
from scikit_build_core import build
print(build.build_sdist(sys.argv[1]))
# Without the ROS interfaces, which take minutes to compile.
options = {"cmake.define.BT_MISSION_INTERFACES": "OFF", "build-dir": sys.argv[1] + "/build"}
print(build.build_wheel(sys.argv[1], options))
"""


def files_of(*folders: str) -> Iterator[str]:
    """The files of some folders of the checkout, as paths in it."""
    for folder in folders:
        for path in sorted((ROOT / folder).rglob("*")):
            if path.is_file() and "__pycache__" not in path.parts:
                yield path.relative_to(ROOT).as_posix()


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the wheel and the source archive of this checkout."""
    folder = tmp_path_factory.mktemp("built")
    done = subprocess.run(
        [sys.executable, "-c", BUILD, str(folder)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
        timeout=PATIENCE_S,
    )
    assert done.returncode == 0, done.stderr
    return folder


@pytest.fixture(scope="module")
def installed(built: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A prefix into which the wheel is unpacked as pip does it."""
    prefix = tmp_path_factory.mktemp("prefix")
    (wheel,) = built.glob("*.whl")
    packages = prefix / "lib" / "python3" / "site-packages"
    shutil.unpack_archive(wheel, packages, "zip")
    (data,) = packages.glob("*.data/data")
    shutil.copytree(data, prefix, dirs_exist_ok=True)
    return prefix


NOT_EDITABLE = (
    "import runpy, sys; sys.meta_path[:] = "
    "[one for one in sys.meta_path if '_editable' not in type(one).__module__]; "
)
"""Takes away what finds this checkout, where it is installed to be edited."""


def called(prefix: Path, folder: Path, script: str) -> str:
    """What a script prints in a folder, with the packages below a prefix."""
    done = subprocess.run(
        [sys.executable, "-c", NOT_EDITABLE + script],
        env=os.environ | {"PYTHONPATH": str(prefix / "lib" / "python3" / "site-packages")},
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
        timeout=PATIENCE_S,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_wheel_has_every_file_of_the_packages(installed: Path) -> None:
    """Pages, styles and settings, too; none is taken for what a build leaves behind."""
    missing = [
        name
        for name in files_of(*PACKAGES)
        if not (installed / "lib" / "python3" / "site-packages" / name).is_file()
    ]
    assert missing == []


def test_the_wheel_has_every_mission_world_robot_and_parameter_file(installed: Path) -> None:
    """With the scenarios and the missions of courses, below share/bt_mission."""
    share = installed / "share" / "bt_mission"
    assert [name for name in files_of(*DATA) if not (share / name).is_file()] == []
    assert {path.name for path in share.iterdir()} == {*DATA, "docs"}


def test_the_wheel_has_the_pages_and_shows_them_in_an_empty_folder(
    installed: Path, tmp_path: Path
) -> None:
    """Without pictures and the settings of the site."""
    share = installed / "share" / "bt_mission"
    pages = [name for name in files_of("docs") if name.endswith(".md")]
    packed = (path for path in (share / "docs").rglob("*") if path.is_file())
    assert sorted(path.relative_to(share).as_posix() for path in packed) == sorted(pages)
    script = (
        "sys.argv[1:] = ['docs', 'two', 'robots']; "
        "runpy.run_module('bt_mission', run_name='__main__')"
    )
    assert called(installed, tmp_path, script).startswith("# Run a fleet\n")


def test_the_wheel_has_the_command_and_the_plugin_of_pytest(installed: Path) -> None:
    """As entry points; and the licence."""
    (about,) = (installed / "lib" / "python3" / "site-packages").glob("*.dist-info")
    entries = (about / "entry_points.txt").read_text(encoding="utf-8")
    assert "bt-mission = bt_mission.__main__:main" in entries.splitlines()
    assert "bt_mission = bt_mission.testing.plugin" in entries.splitlines()
    assert (about / "licenses" / "LICENSE").is_file()


def test_what_is_installed_works_in_an_empty_folder(installed: Path, tmp_path: Path) -> None:
    """The shipped files are those below the prefix of the package, wherever Python's own is."""
    share = installed / "share" / "bt_mission"
    script = "from bt_mission.core.files import find; print(find('robots', 'burger'))"
    result = called(installed, tmp_path, script)
    assert result == f"{share / 'robots' / 'burger.yaml'}\n"
    script = (
        "sys.argv[1:] = ['check', 'missions/square.yaml']; "
        "runpy.run_module('bt_mission', run_name='__main__')"
    )
    output = called(installed, tmp_path, script)
    assert output == f"{share / 'missions' / 'square.yaml'}: mission 'square' is valid (4 nodes)\n"
    assert list(tmp_path.iterdir()) == []


def test_the_source_archive_has_what_a_wheel_is_built_from(built: Path) -> None:
    """And the tests and pages, so that it can be worked on."""
    (archive,) = built.glob("*.tar.gz")
    with tarfile.open(archive) as opened:
        names = {name.partition("/")[2] for name in opened.getnames()}
    wanted = [*files_of(*PACKAGES, *DATA, "interfaces"), "pyproject.toml", "README.md", "LICENSE"]
    assert [name for name in wanted if name not in names] == []
    assert {"tests/test_wheel.py", "docs/README.md", "CONTRIBUTING.md"} <= names
