"""What can be broken on purpose: faults of the robot, its servers, its topics and its world.

- ``fault``: :class:`Fault`, an action on a run that goes on for a while
- ``maker``, ``parameters``: how a fault is declared, and what it makes of what passes
- ``table``: every fault with what it takes, for files, texts and documentation
- ``topics``, ``corruptions``: messages on their way between nodes
- ``goals``: what passes between an action server and its clients
- ``servers``: servers that abort, die or fail
- ``clock``: a clock that is set, or stands still
- ``raising``: exceptions in code
- ``planned``, ``text``, ``values``: :class:`PlannedFault`, a fault as data, and how it is written
- ``plan``: has planned faults begin in a run
- ``robot``, ``world``: sensors, wheels, pushes; obstacles that appear, move and vanish
"""

from __future__ import annotations

from bt_mission.faults.fault import Fault, FaultInstance
from bt_mission.faults.faults import FAULTS, Faults
from bt_mission.faults.planned import PlannedFault
from bt_mission.faults.text import parse_fault

__all__ = ["FAULTS", "Fault", "FaultInstance", "Faults", "PlannedFault", "parse_fault"]
