"""`tools/find-python` picks the newest Python that the project can be installed with."""

import os
import subprocess
import sys

import pytest

from tests.support.project import ROOT

TOOL = ROOT / "tools/find-python"

pytestmark = pytest.mark.process


def _find(*pythons, **environ):
    return subprocess.run(
        ["/bin/bash", str(TOOL), *pythons],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, **environ},
    )


def _script(path, text):
    path.write_text(f"#!/bin/sh\n{text}\n", encoding="utf-8")
    path.chmod(0o755)
    return str(path)


def test_the_first_that_works_is_taken(tmp_path):
    """Names that are not there, and Pythons that do not run, are passed over."""
    broken = _script(tmp_path / "python3.13", "exit 127")
    result = _find("no-such-python", broken, sys.executable)
    assert (result.returncode, result.stdout) == (0, f"{sys.executable}\n")


def test_each_python_that_will_not_do_is_named_with_its_reason(tmp_path):
    """The reasons tell what to install."""
    broken = _script(tmp_path / "python3.13", "exit 127")
    bare = _script(tmp_path / "python3.12", "echo has no C headers: apt install python3.12-dev")
    result = _find("no-such-python", broken, bare)
    assert (result.returncode, result.stdout) == (1, "")
    assert result.stderr.splitlines() == [
        "bt-mission cannot be set up here:",
        "  no-such-python: not found",
        f"  {broken}: does not run",
        f"  {bare}: has no C headers: apt install python3.12-dev",
    ]


def test_a_machine_without_a_compiler_is_told_so(tmp_path):
    """Before a minute of downloads, and in words."""
    _script(tmp_path / "uname", '[ "$1" = -s ] && echo Linux || echo x86_64')
    result = _find(sys.executable, PATH=str(tmp_path))
    assert result.returncode == 1
    assert "no C++ compiler" in result.stderr
    assert "apt install g++" in result.stderr
