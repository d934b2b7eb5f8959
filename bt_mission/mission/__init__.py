"""The mission language: YAML in, frozen and checked steps out. No ROS."""

from bt_mission.mission.expressions import Expression, ExpressionError, Template, resolve
from bt_mission.mission.load import load, load_text
from bt_mission.mission.loaded import Mission
from bt_mission.mission.steps import Step

__all__ = [
    "Expression",
    "ExpressionError",
    "Mission",
    "Step",
    "Template",
    "load",
    "load_text",
    "resolve",
]
