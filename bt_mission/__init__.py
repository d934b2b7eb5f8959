"""Missions in YAML, run as behaviour trees over ROS 2 actions.

Load a mission and run it on your own node::

    import bt_mission, rclpy

    rclpy.init()
    node = rclpy.create_node("my_robot")
    mission = bt_mission.load("square.yaml", set={"speed": 0.2})
    runner = bt_mission.MissionRunner(node, mission)  # uses the caller's node and executor
    while not runner.is_done:
        rclpy.spin_once(node, timeout_sec=0.1)
    print(runner.report())

``load`` raises :class:`InputError`. ``examine`` also compares the mission with the types of ROS,
the servers and the world, and returns it with every diagnostic.

Or in the simulation, without other processes: :class:`Stage`. Names are loaded when they are first
used, so that importing the package loads neither rclpy nor MuJoCo.
"""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Any

from bt_mission.base.lazy import lazy_names

if TYPE_CHECKING:
    from bt_mission.base.actions import ActionName
    from bt_mission.base.diagnostics import Diagnostic, InputError
    from bt_mission.base.errors import BtMissionError
    from bt_mission.executive.executive import Executive
    from bt_mission.executive.goals.goal import GoalClient
    from bt_mission.executive.report import Report
    from bt_mission.language.mission import Mission
    from bt_mission.language.outcome import Outcome
    from bt_mission.language.revision import Revision
    from bt_mission.recording.contents import RecordingOptions
    from bt_mission.recording.reader import read_run as read_recording
    from bt_mission.recording.writer import record
    from bt_mission.ros.graph import NodeOptions
    from bt_mission.ros.mission_node import MissionNode
    from bt_mission.ros.mission_runner import MissionRunner, RunnerOptions
    from bt_mission.scenarios.fleets.loader import load_fleet
    from bt_mission.scenarios.fleets.report import FleetReport
    from bt_mission.scenarios.fleets.run import run_fleet
    from bt_mission.scenarios.loader import load_scenario
    from bt_mission.scenarios.run import run_scenario
    from bt_mission.scenarios.scenario import Scenario, ScenarioResult
    from bt_mission.sessions.check import examine
    from bt_mission.sessions.load import convert, load
    from bt_mission.sessions.stage import Stage
    from bt_mission.sessions.stage_robot import FleetRobot, StageOptions

    __version__: str

__all__ = [
    "ActionName",
    "BtMissionError",
    "Diagnostic",
    "Executive",
    "FleetReport",
    "FleetRobot",
    "GoalClient",
    "InputError",
    "Mission",
    "MissionNode",
    "MissionRunner",
    "NodeOptions",
    "Outcome",
    "RecordingOptions",
    "Report",
    "Revision",
    "RunnerOptions",
    "Scenario",
    "ScenarioResult",
    "Stage",
    "StageOptions",
    "__version__",
    "convert",
    "examine",
    "load",
    "load_fleet",
    "load_scenario",
    "read_recording",
    "record",
    "run_fleet",
    "run_scenario",
]

_load = lazy_names(
    __name__,
    {
        "ActionName": "bt_mission.base.actions",
        "BtMissionError": "bt_mission.base.errors",
        "Diagnostic": "bt_mission.base.diagnostics",
        "Executive": "bt_mission.executive.executive",
        "FleetReport": "bt_mission.scenarios.fleets.report",
        "FleetRobot": "bt_mission.sessions.stage_robot",
        "GoalClient": "bt_mission.executive.goals.goal",
        "InputError": "bt_mission.base.diagnostics",
        "Mission": "bt_mission.language.mission",
        "MissionNode": "bt_mission.ros.mission_node",
        "MissionRunner": "bt_mission.ros.mission_runner",
        "NodeOptions": "bt_mission.ros.graph",
        "Outcome": "bt_mission.language.outcome",
        "RecordingOptions": "bt_mission.recording.contents",
        "Report": "bt_mission.executive.report",
        "Revision": "bt_mission.language.revision",
        "RunnerOptions": "bt_mission.ros.mission_runner",
        "Scenario": "bt_mission.scenarios.scenario",
        "ScenarioResult": "bt_mission.scenarios.scenario",
        "Stage": "bt_mission.sessions.stage",
        "StageOptions": "bt_mission.sessions.stage_robot",
        "convert": "bt_mission.sessions.load",
        "examine": "bt_mission.sessions.check",
        "load": "bt_mission.sessions.load",
        "load_fleet": "bt_mission.scenarios.fleets.loader",
        "load_scenario": "bt_mission.scenarios.loader",
        "read_recording": "bt_mission.recording.reader:read_run",
        "record": "bt_mission.recording.writer",
        "run_fleet": "bt_mission.scenarios.fleets.run",
        "run_scenario": "bt_mission.scenarios.run",
    },
)

if "IPython" in sys.modules:
    from bt_mission.views.notebook import show_richly

    show_richly()


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version  # noqa: PLC0415 - it costs as much as all the rest

        return version("bt-mission")
    return _load(name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
