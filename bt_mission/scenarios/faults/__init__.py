"""What can be broken on purpose: faults of the robot, its servers, its topics and its world.

- ``faults``: the table of all faults, and the methods of ``stage.faults``
- ``messages``, ``servers``, ``robot``, ``world``, ``clock``: its rows by area, each with its effect
- ``kind``, ``parameters``: what a row says; usage, checks and the fault itself derive from it
- ``effects``, ``corruptions``: what becomes of things that pass on a channel
- ``fault``: :class:`Fault`, an action on a run that lasts for a while
- ``planned``, ``text``, ``values``: :class:`PlannedFault`, a fault as data, and how it is written
- ``plan``, ``located``: planned faults begin in a run; errors have the place of their text
- ``drawable``, ``drawing``: random faults
"""

from __future__ import annotations

from bt_mission.scenarios.faults.fault import Fault, FaultInstance
from bt_mission.scenarios.faults.faults import FAULTS, Faults
from bt_mission.scenarios.faults.planned import PlannedFault
from bt_mission.scenarios.faults.text import parse_fault

__all__ = ["FAULTS", "Fault", "FaultInstance", "Faults", "PlannedFault", "parse_fault"]
