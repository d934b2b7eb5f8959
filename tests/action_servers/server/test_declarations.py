"""Declarations of actions: what is read from the source, true of their types, and loaded."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import fields
from importlib import import_module

import pytest

from action_servers.core.action import Action, action
from action_servers.core.limits import faults
from bt_mission.base.actions import ActionName, declared
from bt_mission.language.message_types import field_at, value_type
from bt_mission.robots.model import load_robot
from bt_mission.ros.interface_types import action_type, fill, shapes

WITH_ARM = load_robot("waffle_arm")
MODULES = sorted({declaration.module for declaration in declared().values()})


@pytest.mark.parametrize("name", declared())
def test_what_is_read_is_what_is_imported(name):
    """Field by field, with the defaults."""
    result, known = action(name), declared()[name].known
    for field in fields(ActionName):
        assert getattr(result, field.name) == getattr(known, field.name)


@pytest.mark.parametrize("module", MODULES)
def test_no_declaration_of_a_module_is_missed(module):
    """Whatever its name and its layout."""
    imported = vars(import_module(module)).values()
    names = {value.name for value in imported if isinstance(value, Action)}
    assert names == {name for name, first in declared().items() if first.module == module}


@pytest.mark.parametrize("name", declared())
def test_every_limit_names_a_field_of_the_type(name):
    """So does every range of the feedback, and every field of the example."""
    result = action(name)
    shape = shapes(result.type)
    goal = fill(action_type(result.type).Goal(), result.example)
    for limit in result.limits_with(WITH_ARM):
        field_at(shape.sends, limit.field)  # raises UnknownField
    for field in result.feedback(goal):
        assert shape.asks is not None
        assert value_type(field_at(shape.asks, field)) in ("integer", "number")
    assert not any(faults(goal, result.limits_with(WITH_ARM)))
    assert result.misfit(goal, WITH_ARM) is None


@pytest.mark.parametrize("name", declared())
def test_a_goal_of_each_type_can_be_checked(name):
    """A message with all fields at 0 meets no exception."""
    result = action(name)
    goal = action_type(result.type).Goal()
    assert all(fault is None or fault for fault in faults(goal, result.limits_with(WITH_ARM)))
    assert result.misfit(goal, WITH_ARM) is None or result.misfit(goal, load_robot("waffle"))


def printed(code: str) -> str:
    """What a program prints."""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return done.stdout.strip()


def test_names_are_read_without_ros_and_numpy():
    """The mission language imports nothing of the servers."""
    code = (
        "import sys\n"
        "from bt_mission.language.action_names import ACTION_NAMES\n"
        "assert 'turn' in ACTION_NAMES\n"
        "heavy = {'rclpy', 'mujoco', 'numpy', 'scipy', 'cv2', 'action_servers'}\n"
        "print(sorted(heavy & set(sys.modules)))"
    )
    assert printed(code) == "[]"


HEAVY = {"scipy", "cv2", "PIL"}
PROGRAM = """\
import json
from pathlib import Path
import rclpy
from rclpy.context import Context
from action_servers.server.node import ServerOptions, ServersNode
from bt_mission.base.dds.discovery import isolate
from bt_mission.robots.model import load_robot

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


@pytest.mark.thorough
@pytest.mark.process
def test_libraries_come_with_the_actions_that_need_them() -> None:
    """A process that serves all of them has loaded everything before the first goal."""
    output = printed(f"import sys; sys.path[:0] = {sys.path!r}\n{PROGRAM}")
    (few, at_first), (every, at_last) = json.loads(output)
    assert set(few) == {"/turn", "/wait"}
    assert HEAVY.isdisjoint(at_first)
    assert {"/navigate_to_pose", "/explore_frontiers", "/camera_sweep", "/find_colour"} < set(every)
    assert set(at_last) > HEAVY
    assert {"scipy.ndimage", "action_servers.navigation.actions"} < set(at_last)
