"""What keeps goals away for a while: the stop service, and motors that are off."""

from __future__ import annotations

from action_servers.core.maneuver import ErrorCode
from action_servers.core.pilot import Pilot

STOPPED = "stopped"
MOTORS_OFF = "motors off"


class Interlock:
    """Ends what the pilot does, and refuses goals until the cause is gone.

    A stop ends and refuses everything; motors that are off, only what drives.
    """

    def __init__(self, pilot: Pilot) -> None:
        self._pilot = pilot
        self._stopped = False
        self._motors_on = True

    def stop(self) -> str:
        """Stop the base and end every goal, however often; return what was done, in words."""
        already, self._stopped = self._stopped, True
        self._pilot.stop(STOPPED)
        return "stopped already" if already else "stopped; goals are refused until release"

    def release(self) -> str:
        """Let goals be accepted again; return what was done, in words."""
        was_stopped, self._stopped = self._stopped, False
        return "released" if was_stopped else "was not stopped"

    def set_motors(self, *, on: bool) -> None:
        """Take in whether the motors are on; they are until told otherwise."""
        self._motors_on = on
        if not on:
            self._pilot.stop_driving(MOTORS_OFF, ErrorCode.MOTORS_OFF)

    def refusal(self, *, needs_base: bool) -> str | None:
        """Return why a goal is not accepted now, or None."""
        if self._stopped:
            return f"{STOPPED}; call the service release to go on"
        if needs_base and not self._motors_on:
            return f"{MOTORS_OFF}; switch them on with the service motor_power"
        return self._pilot.refusal(needs_base=needs_base)
