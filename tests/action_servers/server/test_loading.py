"""What computes pictures and paths is loaded when such an action is offered, not by its goals."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

pytestmark = pytest.mark.process

HEAVY = {"scipy", "cv2", "PIL"}
PROGRAM = """\
import json
from pathlib import Path
import rclpy
from rclpy.context import Context
from action_servers.server.node import ServerOptions, ServersNode
from bt_mission.core.dds.discovery import isolate
from bt_mission.core.robot.model import load_robot

isolate(visible=False)
context = Context()
rclpy.init(context=context)
options = ServerOptions(
    image_folder=Path("images"), lean=True, context=context, at_first=("turn", "wait")
)
node = ServersNode(load_robot("waffle"), options)
few = [*node.actions], [*sys.modules]
node.offer_all()
every = [*node.actions], [*sys.modules]
node.destroy_node()
context.shutdown()
print(json.dumps([few, every]))
"""


def test_libraries_come_with_the_actions_that_need_them() -> None:
    """A process that serves all of them has loaded everything before the first goal."""
    done = subprocess.run(
        [sys.executable, "-c", f"import sys; sys.path[:0] = {sys.path!r}\n{PROGRAM}"],
        capture_output=True,
        text=True,
        check=True,
    )
    (few, at_first), (every, at_last) = json.loads(done.stdout)
    assert set(few) == {"/turn", "/wait"}
    assert HEAVY.isdisjoint(at_first)
    assert {"/navigate_to_pose", "/explore_frontiers", "/camera_sweep", "/find_colour"} < set(every)
    assert set(at_last) > HEAVY
    assert {"scipy.ndimage", "action_servers.navigation.actions"} < set(at_last)
