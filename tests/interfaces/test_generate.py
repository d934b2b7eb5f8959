"""What generates the interfaces for `pip install`: the files of ROS's own generators."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.processes import PATIENCE_S
from tests.support.project import ROOT

pytestmark = pytest.mark.process

SCRIPT = """\
import importlib.util, pathlib, sys
spec = importlib.util.spec_from_file_location("generate", sys.argv[1])
generate = importlib.util.module_from_spec(spec)
spec.loader.exec_module(generate)
package = pathlib.Path(sys.argv[2])
generate.generate(package, pathlib.Path("plain").resolve())
generate.remember()
generate.generate(package, pathlib.Path("fast").resolve())
"""
COMMENT = re.compile(r"/\*.*?\*/|//[^\n]*|\s+", re.DOTALL)


@pytest.mark.thorough
def test_remembered_texts_give_the_same_sources(tmp_path: Path) -> None:
    """A message, an action and a service's worth of templates, but for comments of C."""
    package = ROOT / "interfaces" / "example_interfaces"
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, str(ROOT / "interfaces/wheel/generate.py"), str(package)],
        cwd=tmp_path,
        env=os.environ | {"PYTHONHASHSEED": "0"},
        capture_output=True,
        text=True,
        check=False,
        timeout=PATIENCE_S,
    )
    assert done.returncode == 0, done.stderr
    plain, fast = (
        {
            path.relative_to(tmp_path / way): COMMENT.sub("", path.read_text(encoding="utf-8"))
            for path in (tmp_path / way).rglob("*.*")
            if path.is_file() and path.parent != tmp_path / way
        }
        for way in ("plain", "fast")
    )
    assert len(plain) > 30
    assert plain == fast
