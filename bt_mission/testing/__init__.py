"""The parts of tests of missions, and the pytest plugin that provides them.

The fixtures are available wherever the package is installed (``plugin``): ``stage``, a
:class:`Stages`, starts a :class:`Run`; a condition looks at a :class:`Moment` of it. The names
below are for annotations and ``pytest.raises``; they are loaded when they are first used, so that
a session without missions pays nothing.
"""

from typing import TYPE_CHECKING

from bt_mission.base.lazy import lazy_names

if TYPE_CHECKING:
    from bt_mission.scenarios.faults import FaultInstance, Faults
    from bt_mission.scenarios.faults.errors import ScenarioError
    from bt_mission.sessions.scripted_server import ScriptedGoal, ScriptedServer
    from bt_mission.testing.history import Recorded, TestedGoal
    from bt_mission.testing.live_graph import LiveGraph, Process
    from bt_mission.testing.moment import Moment, NodeView
    from bt_mission.testing.programs import ProgramRun
    from bt_mission.testing.run import NeverHeldError, Run
    from bt_mission.testing.stages import Stages

__all__ = [
    "FaultInstance",
    "Faults",
    "LiveGraph",
    "Moment",
    "NeverHeldError",
    "NodeView",
    "Process",
    "ProgramRun",
    "Recorded",
    "Run",
    "ScenarioError",
    "ScriptedGoal",
    "ScriptedServer",
    "Stages",
    "TestedGoal",
]

__getattr__ = lazy_names(
    __name__,
    {
        "FaultInstance": "bt_mission.scenarios.faults",
        "Faults": "bt_mission.scenarios.faults",
        "TestedGoal": "bt_mission.testing.history",
        "LiveGraph": "bt_mission.testing.live_graph",
        "Moment": "bt_mission.testing.moment",
        "NeverHeldError": "bt_mission.testing.run",
        "NodeView": "bt_mission.testing.moment",
        "Process": "bt_mission.testing.live_graph",
        "ProgramRun": "bt_mission.testing.programs",
        "Recorded": "bt_mission.testing.history",
        "Run": "bt_mission.testing.run",
        "ScenarioError": "bt_mission.scenarios.faults.errors",
        "ScriptedGoal": "bt_mission.sessions.scripted_server",
        "ScriptedServer": "bt_mission.sessions.scripted_server",
        "Stages": "bt_mission.testing.stages",
    },
)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
