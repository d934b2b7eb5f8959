"""docs/tutorials/embed.md: the scripts run as written, beside the simulator and the servers."""

import re
import sys

import pytest

from bt_mission.testing import LiveGraph
from tests.support.project import ROOT

PAGE = ROOT / "docs" / "tutorials" / "embed.md"
CODE = PAGE.parent / "code"


@pytest.mark.process
@pytest.mark.parametrize(
    ("script", "output"),
    [
        pytest.param("ten_lines", "side: success", marks=pytest.mark.thorough),
        ("patrol_node", "1 round, node.messages > 0=True"),
    ],
)
def test_a_script_runs_as_written(
    live_graph: LiveGraph, monkeypatch: pytest.MonkeyPatch, script: str, output: str
) -> None:
    """In a folder with nothing but the script and the mission of the page."""
    mission = re.search(r"```yaml side\.yaml\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL)
    assert mission is not None
    (live_graph.folder / "side.yaml").write_text(mission[1], encoding="utf-8")
    monkeypatch.chdir(live_graph.folder)
    live_graph.robot("empty_arena")
    program = live_graph.start_program(script, sys.executable, str(CODE / f"{script}.py"))
    assert program.wait(within=180) == 0, program.output
    assert output in program.output
