"""The wheel of this checkout, and an environment into which it is installed."""

from __future__ import annotations

import fcntl
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.processes import PATIENCE_S
from tests.support.project import ROOT

BUILD = """\
import sys
from scikit_build_core import build
print(build.build_sdist(sys.argv[1]))
# Without the ROS interfaces, which take minutes to compile.
options = {"cmake.define.BT_MISSION_INTERFACES": "OFF", "build-dir": sys.argv[1] + "/build"}
print(build.build_wheel(sys.argv[1], options))
"""
PACKAGES_FOLDER = Path(
    "lib", f"python{sys.version_info.major}.{sys.version_info.minor}", "site-packages"
)
"""Of a virtual environment."""
PROGRAMS = {
    "bt-mission": "from bt_mission.__main__ import main; sys.exit(main())",
    "pytest": "from _pytest.config import _console_main; sys.exit(_console_main())",
    "dask": "from dask.__main__ import main; sys.exit(main())",
}
"""The commands that pages call, as pip writes them."""
GUARD = "import sys\nif __name__ == '__main__':\n    "
"""Processes that a command starts with `spawn` read its file, too."""


@pytest.fixture(scope="session")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the wheel and the source archive of this checkout, made once for all forks."""
    session = tmp_path_factory.getbasetemp()
    folder = (session.parent if session.name.startswith("process") else session) / "built"
    with folder.with_suffix(".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not folder.is_dir():
            unfinished = folder.with_suffix(".unfinished")
            unfinished.mkdir()
            subprocess.run(
                [sys.executable, "-c", BUILD, str(unfinished)],
                cwd=ROOT,
                check=True,
                stdout=subprocess.DEVNULL,
                timeout=PATIENCE_S,
            )
            unfinished.rename(folder)
    return folder


@pytest.fixture(scope="session")
def installed(built: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A virtual environment with the wheel, and with the packages of this one beside it.

    Nothing in it leads to the checkout. The interfaces of ROS are those of this environment.
    """
    prefix = tmp_path_factory.mktemp("installed")
    here = Path(sys.prefix)
    (wheel,) = built.glob("*.whl")
    shutil.unpack_archive(wheel, prefix / PACKAGES_FOLDER, "zip")
    (data,) = (prefix / PACKAGES_FOLDER).glob("*.data/data")
    shutil.copytree(data, prefix, dirs_exist_ok=True)
    shutil.copy(here / "pyvenv.cfg", prefix)
    _link(here / PACKAGES_FOLDER, prefix / PACKAGES_FOLDER)
    _link(here / "lib", prefix / "lib")
    _link(here / "share", prefix / "share")
    _link(here / "share" / "bt_mission", prefix / "share" / "bt_mission")
    (prefix / "bin").mkdir()
    (prefix / "bin" / "python").symlink_to(os.path.realpath(sys.executable))
    for name, code in PROGRAMS.items():
        program = prefix / "bin" / name
        program.write_text(f"#!{prefix / 'bin' / 'python'}\n{GUARD}{code}\n")
        program.chmod(0o755)
    return prefix


def _link(here: Path, there: Path) -> None:
    """Link what a folder of this environment has, and the other has not, but for this checkout."""
    for path in here.iterdir():
        if not (there / path.name).exists() and "_editable" not in path.name:
            (there / path.name).symlink_to(path)


def run_in(prefix: Path, folder: Path, *arguments: str) -> str:
    """Return what a program of the environment prints in a folder."""
    done = subprocess.run(
        [prefix / "bin" / arguments[0], *arguments[1:]],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
        timeout=PATIENCE_S,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout
