"""Code of users on the virtual clock, as it is: it may sleep, spin, wait and start threads.

Each callback runs on a greenlet. Where it blocks, the greenlet is suspended, and virtual time goes
on; the executor that the code uses decides what else may run meanwhile.

- ``calls``: :class:`Call`, one run of such code, and what it waits for
- ``host``: :class:`ProgramHost`, which runs calls on a :class:`VirtualTimeExecutor`
- ``executors``: rclpy's executors as this code sees them
- ``replaced``: the functions that block or read a clock, replaced while a call runs
- ``clocks``, ``threads``: what they are replaced with
- ``stuck``: calls that wait for each other, for ever
"""

from bt_mission.programs.calls import Program
from bt_mission.programs.host import ProgramHost

__all__ = ["Program", "ProgramHost"]
