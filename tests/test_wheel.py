"""What is installed: the wheel and the source archive hold every file that the product reads."""

from __future__ import annotations

import shutil
import tarfile
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import pytest

from tests.support.installed import PACKAGES_FOLDER, run_in
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


def files_of(*folders: str) -> Iterator[str]:
    """The files of some folders of the checkout, as paths in it."""
    for folder in folders:
        for path in sorted((ROOT / folder).rglob("*")):
            if path.is_file() and "__pycache__" not in path.parts:
                yield path.relative_to(ROOT).as_posix()


def test_the_wheel_has_every_file_of_the_packages(installed: Path) -> None:
    """Pages, styles and settings, too; none is taken for what a build leaves behind."""
    missing = [
        name for name in files_of(*PACKAGES) if not (installed / PACKAGES_FOLDER / name).is_file()
    ]
    assert missing == []


def test_the_wheel_has_every_mission_world_robot_and_parameter_file(installed: Path) -> None:
    """With the scenarios and the missions of courses, below share/bt_mission."""
    share = installed / "share" / "bt_mission"
    assert [name for name in files_of(*DATA) if not (share / name).is_file()] == []
    assert {path.name for path in share.iterdir()} == {*DATA, "docs", "ros"}


def test_the_wheel_has_the_pages(installed: Path) -> None:
    """With the examples; without pictures and the settings of the site."""
    share = installed / "share" / "bt_mission"
    ends = (".md", ".py", ".yaml")
    site = "docs/site/"
    pages = [name for name in files_of("docs") if name.endswith(ends) and not name.startswith(site)]
    packed = (path for path in (share / "docs").rglob("*") if path.is_file())
    assert sorted(path.relative_to(share).as_posix() for path in packed) == sorted(pages)


def test_the_wheel_has_the_command_and_the_plugin_of_pytest(installed: Path) -> None:
    """As entry points; and the licence."""
    (about,) = (installed / PACKAGES_FOLDER).glob("bt_mission-*.dist-info")
    entries = (about / "entry_points.txt").read_text(encoding="utf-8")
    assert "bt-mission = bt_mission.__main__:main" in entries.splitlines()
    assert "bt_mission = bt_mission.testing.plugin" in entries.splitlines()
    assert (about / "licenses" / "LICENSE").is_file()


def test_what_is_installed_works_in_an_empty_folder(installed: Path, tmp_path: Path) -> None:
    """The shipped files are those below the prefix of the package, wherever Python's own is."""
    share = installed / "share" / "bt_mission"
    script = "from bt_mission.base.files import find; print(find('robots', 'burger'))"
    result = run_in(installed, tmp_path, "python", "-c", script)
    assert result == f"{share / 'robots' / 'burger.yaml'}\n"
    output = run_in(installed, tmp_path, "bt-mission", "check", "missions/square.yaml")
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
