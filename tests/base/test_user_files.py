"""Files of a user find the modules beside them, as `python FILE` does; two folders never mix."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from bt_mission.base.user_files import files_beside, load_file

PROGRAM = """\
import os, helper
import parts.wheel
import parts.wheel as wheel
from helper import NAME as name
from parts import axle, wheel as again

def late():
    import later
    from later import WORD
    return later.WORD + WORD

def all_names():
    return [helper.NAME, name, parts.wheel.NAME, wheel.NAME, again.NAME, axle.NAME, late()]

print(all_names(), os.sep)
"""


def folder(path: Path, word: str) -> Path:
    """A folder with a program and its modules, each with this word; returns the program."""
    (path / "parts").mkdir(parents=True)
    texts = {
        "srv.py": PROGRAM,
        "helper.py": "from parts import axle\nNAME = 'helper of ' + axle.PLACE\n",
        "later.py": f"WORD = '{word}'\n",
        "json.py": "raise RuntimeError('a module of Python is not replaced')\n",
        "rclpy.py": "raise RuntimeError('an installed module is not replaced')\n",
        "parts/__init__.py": "",
        "parts/axle.py": f"import json, rclpy\nPLACE = '{word}'\nNAME = f'axle of {{PLACE}}'\n",
        "parts/wheel.py": "from . import axle\nNAME = 'wheel of ' + axle.PLACE\n",
    }
    for name, text in texts.items():
        (path / name).write_text(text)
    return path / "srv.py"


def test_two_folders_have_a_helper_each(tmp_path: Path) -> None:
    """Also in functions that import later, in any order; nothing is left on the path."""
    before, known = list(sys.path), set(sys.modules)
    files = {word: folder(tmp_path / word / "a.b", word) for word in ("here", "there")}
    modules = {word: load_file(path) for word, path in files.items()}
    for word in ("there", "here"):
        wheel = f"wheel of {word}"
        names = [f"helper of {word}"] * 2 + [wheel] * 3 + [f"axle of {word}", word + word]
        assert modules[word].all_names() == names
    assert load_file(files["here"]) is modules["here"]
    assert sys.path == before
    assert {"helper", "parts", "later", "srv"} & (set(sys.modules) - known) == set()
    assert not list(tmp_path.rglob("*.pyc")), "Python itself would read what was compiled for us"


def test_it_finds_what_python_finds(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The same program prints the same, apart from modules that must not be replaced."""
    file = folder(tmp_path, "here")
    for name in ("json.py", "rclpy.py"):
        (tmp_path / name).unlink()
    load_file(file)
    done = subprocess.run([sys.executable, "-B", file], capture_output=True, text=True, check=True)
    assert capsys.readouterr().out == done.stdout


def test_a_file_that_raises_is_loaded_again(tmp_path: Path) -> None:
    """Its error has the line of the file, and of a module beside it."""
    file = tmp_path / "srv.py"
    file.write_text("import helper\n")
    (tmp_path / "helper.py").write_text("\n\nraise ValueError('no')\n")
    for _ in range(2):
        with pytest.raises(ValueError, match="no") as caught:
            load_file(file)
        assert (Path(str(caught.traceback[-1].path)).name, caught.traceback[-1].lineno) == (
            "helper.py",
            2,
        )
    (tmp_path / "helper.py").write_text("WORD = 1\n")
    assert load_file(file).helper.WORD == 1


def test_the_files_that_a_file_needs_are_listed(tmp_path: Path) -> None:
    """For copies of a mission, and for workers of a sweep."""
    file = folder(tmp_path, "here")
    names = {path.relative_to(tmp_path).as_posix() for path in files_beside(file)}
    assert names == {
        *("helper.py", "later.py"),
        *("parts/__init__.py", "parts/axle.py", "parts/wheel.py"),
    }
