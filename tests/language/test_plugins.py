"""Leaves and actions of other packages, found by their entry points."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from bt_mission.language.plugins import PythonError, find_class
from tests.support.thorough import sample

MODULE = """
from py_trees.behaviour import Behaviour
from py_trees.common import Status
from bt_mission import ActionName

CHARGE = ActionName(name="charge", type="bt_mission_interfaces/action/Turn")
WRONG = "no short name"

class Blink(Behaviour):
    times: int = 1
    def update(self):
        return Status.SUCCESS
"""

ENTRIES = """
[bt_mission.leaves]
blink = my_robot:Blink
gone = my_robot:Gone

[bt_mission.actions]
charge = my_robot:CHARGE
wrong = my_robot:WRONG
missing = my_robots:CHARGE
turn = my_robot:CHARGE
wait = my_robot:CHARGE
outputs = my_robot:CHARGE
"""

MISSION = """
mission: t
tree:
  sequence:
    - charge: {angle: 90}
      timeout: 9
    - python: blink
      inputs: {times: 2}
    - python: gone
    - python: blonk
    - wrong: {}
    - missing: {}
    - turn: {angle: 9}
      timeout: 9
    - wait: 2.0
"""


@pytest.fixture
def installed(tmp_path: Path) -> Path:
    """A folder with a package in it, as pip leaves one."""
    (tmp_path / "my_robot.py").write_text(MODULE, encoding="utf-8")
    about = tmp_path / "my_robot-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: my-robot\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text(ENTRIES, encoding="utf-8")
    (tmp_path / "mission.yaml").write_text(MISSION, encoding="utf-8")
    return tmp_path


CODE = """
import sys; sys.path.insert(0, '.')
from bt_mission.sessions.check import examine
print(*(str(fault).splitlines()[0] for fault in examine('mission.yaml')[1]), sep='\\n')
from bt_mission.language.action_names import ACTION_NAMES, BROKEN
print(ACTION_NAMES['turn'].name, ACTION_NAMES['charge'].name)
print(BROKEN['wait'])
print(BROKEN['outputs'])
"""


def checked(folder: Path) -> list[str]:
    """Return the diagnostics of the mission in a folder with a package, and names of actions."""
    command = [sys.executable, "-c", CODE]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True)
    return done.stdout.splitlines()


def test_a_package_brings_leaves_and_actions(installed: Path) -> None:
    """What works is used; what does not is said where it is wanted, and nothing else suffers."""
    assert checked(installed) == [
        (
            "mission.yaml:9:15: error: the plug-in 'gone' (my_robot:Gone) cannot be imported: "
            "AttributeError: module 'my_robot' has no attribute 'Gone' [BT-215]"
        ),
        (
            "mission.yaml:10:15: error: unknown plug-in 'blonk' (known: blink, gone); "
            "did you mean 'blink'? [BT-215]"
        ),
        (
            "mission.yaml:11:7: error: the plug-in 'wrong' cannot be used: my_robot:WRONG: "
            "expected an ActionName, got str [BT-215]"
        ),
        (
            "mission.yaml:12:7: error: the plug-in 'missing' cannot be used: my_robots:CHARGE "
            "cannot be imported: ModuleNotFoundError: No module named 'my_robots' [BT-215]"
        ),
        "turn charge",
        *(
            f"my_robot:CHARGE: '{name}' is a word of the mission language; give the entry point "
            "another name"
            for name in ("wait", "outputs")
        ),
    ]


def test_a_module_that_ends_python_ends_only_itself(tmp_path: Path) -> None:
    """A script that calls `sys.exit` is no module with behaviours; its user is told so."""
    (tmp_path / "script.py").write_text("import sys\nsys.exit('bye')\n", encoding="utf-8")
    with pytest.raises(PythonError) as caught:
        find_class("script.py:Blink", str(tmp_path / "mission.yaml"))
    assert str(caught.value) == "script.py cannot be imported: SystemExit: bye (script.py:2)"


DECLARED = """
from action_servers import Action, NumberLimit, Refusal

CHARGE = Action(
    name="charge",
    type="bt_mission_interfaces/action/Turn",
    needs=("base", "scan", "odometry"),
    example={"angle": 45.0},
    plan=lambda _goal, _now, robot: Refusal(f"no {robot.name} charges here"),
    limits=lambda robot, tuning: (
        NumberLimit(field="angle", low=0.0, high=90.0, unit="deg", source="the charger"),
    ),
)
"""


@pytest.mark.parametrize(
    ("goal", "expected"),
    sample(
        [
            (
                "{angle: 100}",
                "got 100: the server of charge refuses that (limit: the charger)",
            ),
            ("30", "write 'charge: {angle: 30}'"),
        ],
        4,
    ),
)
def test_a_declared_action_is_checked_as_ours(installed: Path, goal: str, expected: str) -> None:
    """By its limits, and a value without its field is recognized by the example."""
    (installed / "my_robot.py").write_text(DECLARED, encoding="utf-8")
    (installed / "mission.yaml").write_text(
        f"mission: t\ntree:\n  charge: {goal}\n  timeout: 9\n", encoding="utf-8"
    )
    assert expected in checked(installed)[0]
