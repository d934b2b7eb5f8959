"""MuJoCo is imported without a search for libraries of windows, in a process of its own."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.process

WITHOUT_PROCESSES = """\
import subprocess

def refuse(*arguments, **options):
    raise AssertionError(arguments)

subprocess.Popen = refuse
import mujoco
import glfw
print(os.environ.get("PYGLFW_LIBRARY"))
"""
TELLING = "print(os.environ.get('PYGLFW_LIBRARY'))\n"


def output_of(program: str, **variables: str) -> str:
    """What a program prints after the import of the simulation, with these variables alone."""
    names = ("PYGLFW_LIBRARY", "PYGLFW_LIBRARY_VARIANT", "XDG_SESSION_TYPE")
    kept = {name: value for name, value in os.environ.items() if name not in names}
    code = f"import sys; sys.path[:0] = {sys.path!r}\nimport os\nimport sim\n{program}"
    done = subprocess.run(
        [sys.executable, "-c", code],
        env=kept | variables,
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout.strip()


def test_no_process_is_started() -> None:
    """The package glfw would ask a new Python for the version of each library."""
    library = Path(output_of(WITHOUT_PROCESSES))
    assert library.name == "libglfw.so"
    assert library.is_file()


@pytest.mark.parametrize(
    ("variables", "left"),
    [
        ({"PYGLFW_LIBRARY": "/opt/libglfw.so"}, "/opt/libglfw.so"),
        ({"PYGLFW_LIBRARY_VARIANT": "wayland"}, "None"),
        ({"XDG_SESSION_TYPE": "wayland"}, "None"),
    ],
)
def test_a_choice_of_the_user_is_kept(variables: dict[str, str], left: str) -> None:
    """And that of a desktop which needs another library."""
    assert output_of(TELLING, **variables) == left
