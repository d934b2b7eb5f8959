"""What a terminal shows of a fleet while it runs."""

from __future__ import annotations

import io
from pathlib import Path

import pytest

from bt_mission.core.terminal.console import EscapingConsole
from bt_mission.fleets.loader import load_fleet
from bt_mission.sessions.drive import drive
from bt_mission.sessions.stage import Stage
from bt_mission.views.terminal.views import LiveView
from tests.support.terminal import shown_by_terminal


def shown(path: Path, folder: Path, height: int) -> list[str]:
    """Run a fleet; return what its picture leaves on a terminal of so many rows."""
    plan = load_fleet(path)
    stream = io.StringIO()
    console = EscapingConsole(stream, width=80, height=height, force_terminal=True, _environ={})
    with Stage(robots=plan.robots, image_folder=folder, options=plan.stage_options) as stage:
        drive(stage, [LiveView(console, title=plan.title)])
    rows = shown_by_terminal(stream.getvalue())
    return [row.split("   ")[0] if "x real time" in row else row for row in rows if row]


@pytest.fixture
def fleet(tmp_path: Path) -> Path:
    """A fleet of three robots that wait for a moment each."""
    path = tmp_path / "it.yaml"
    robots = "".join(
        f"  r{n}:\n    mission:\n      mission: m{n}\n"
        f"      tree: {{sequence: [{{wait: 0.{n}}}, {{log: hm}}]}}\n"
        f"    start: {{x: {n - 2}}}\n"
        for n in (1, 2, 3)
    )
    path.write_text(f"fleet: three\nworld: empty_arena\nrobots:\n{robots}", encoding="utf-8")
    return path


def test_each_robot_has_its_tree_below_a_line_of_its_own(fleet: Path, tmp_path: Path) -> None:
    """What missions say scrolls by above, with the name."""
    assert shown(fleet, tmp_path, 30) == [
        "     0.15 s  r1  hm",
        "     0.25 s  r2  hm",
        "     0.35 s  r3  hm",
        "three in empty_arena (3 robots, seed 0)",
        *(
            row
            for n in (1, 2, 3)
            for row in (
                f"r{n}  m{n}  success",
                f"✓ m{n}",
                "  ✓ wait  0.0 s left",
                "  ✓ log  hm",
            )
        ),
    ]


def test_where_there_is_no_room_for_trees_each_robot_has_its_line(
    fleet: Path, tmp_path: Path
) -> None:
    """A terminal of seven rows shows the three of them all the same."""
    assert shown(fleet, tmp_path, 7)[3:] == [
        "three in empty_arena (3 robots, seed 0)",
        "r1  m1  success",
        "r2  m2  success",
        "r3  m3  success",
    ]
