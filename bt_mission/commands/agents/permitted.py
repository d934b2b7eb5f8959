"""The missions that a server of a site runs: those with a permit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from typing_extensions import override

from bt_mission.commands.agents.folder import AgentFolder
from bt_mission.commands.agents.permits import Permit, PermitError, spend, valid_permit
from bt_mission.commands.agents.site import Site
from bt_mission.language.loader import required
from bt_mission.sessions.served_missions import ServedMissions

if TYPE_CHECKING:
    from bt_mission.language.mission import Mission

PERMIT = "permit:"
"""Begins the path of a goal that asks for a proposal: ``permit:NAME``."""


@dataclass(frozen=True, kw_only=True)
class PermittedMissions(ServedMissions):
    """Proposals of agents with a permit, besides the missions of served folders.

    Attributes:
        site: Its requirements halt the mission.
        folder: The folder of proposals and permits.
    """

    site: Site
    folder: AgentFolder

    @override
    def load(self, goal: Any) -> Mission:
        """Return a mission as for a server without agents, or that of a permit, which stays valid.

        Raises:
            PermitError: Without a valid permit, or with values that a permit does not name.
            InputError: The mission has errors.
        """
        return self._permitted(goal)[1] if _needs_permit(goal) else super().load(goal)

    @override
    def begin(self, goal: Any, loaded: Mission) -> Mission:
        """Return the mission to start; its permit, judged again, is spent.

        The bytes that are compared with the permit are those that run.

        Raises:
            PermitError: The permit is no longer valid.
            InputError: The mission has errors.
        """
        if not _needs_permit(goal):
            return super().begin(goal, loaded)
        permit, mission = self._permitted(goal)
        spend(self.folder, permit)
        return mission

    def _permitted(self, goal: Any) -> tuple[Permit, Mission]:
        if goal.text or goal.inputs or goal.seed != -1:
            raise PermitError("a permit decides on text, inputs and seed: send the path alone")
        permit, proposal = valid_permit(self.folder, self.site, goal.path.removeprefix(PERMIT))
        return permit, required(self.site.examine(proposal))


def _needs_permit(goal: Any) -> bool:
    return bool(goal.path.startswith(PERMIT))
