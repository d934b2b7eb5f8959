"""A mission, and a server of the user's own that does what it asks for."""

from __future__ import annotations

from pathlib import Path

TURN_SERVER = """\
from bt_mission_interfaces.action import Turn
from rclpy.action import ActionServer
from rclpy.node import Node

MADE = []

class TurnServer(Node):
    def __init__(self, **options):
        super().__init__("own_turn", **options)
        MADE.append(self.get_fully_qualified_name())
        self.server = ActionServer(self, Turn, "turn", self.turn)

    def turn(self, goal):
        goal.succeed()
        return Turn.Result(angle_turned=1234.0)
"""
TURNS = """\
mission: turns
world: empty_arena
{nodes}
tree:
  sequence:
    - turn: {{angle: 90}}
      timeout: 20
      outputs: {{angle_turned: turned}}
    - check: turned == 1234
"""


def written(folder: Path, nodes: str = "", code: str = TURN_SERVER) -> Path:
    """Write a server and a mission; gives the mission."""
    (folder / "server.py").write_text(code, encoding="utf-8")
    path = folder / "turns.yaml"
    path.write_text(TURNS.format(nodes=f"nodes: [{nodes}]" if nodes else ""), encoding="utf-8")
    return path
