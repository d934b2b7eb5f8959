"""Whether a running mission can become another version, in every state that it can reach."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from typing import Any

from typing_extensions import override

from bt_mission.base.text import counted, escape_control
from bt_mission.commands.prove.claims import Broken, Claims
from bt_mission.commands.prove.environment import Environment
from bt_mission.executive.revision import RevisionPlan
from bt_mission.executive.status import MissionStatus
from bt_mission.language.mission import Mission


@dataclass
class RevisionRefusal:
    """Why a revision is refused in some states.

    Attributes:
        states: The number of these states.
        state: The first of them.
        steps: A shortest way to it, a line for each answer.
    """

    reason: str
    states: int = 0
    state: int = -1
    steps: tuple[str, ...] = ()


@dataclass
class RevisedEverywhere:
    """The results of a dry run of a revision in every state in which the mission runs.

    Attributes:
        states: The number of these states.
        cancels: The leaves whose goals are cancelled in some state.
        refusals: By reason.
    """

    states: int = 0
    cancels: set[str] = field(default_factory=set)
    refusals: dict[str, RevisionRefusal] = field(default_factory=dict)

    def find_ways(self, steps_to: Callable[[int], tuple[str, ...]]) -> None:
        """Find the ways to the states in which it is refused."""
        for refusal in self.refusals.values():
            refusal.steps = steps_to(refusal.state)

    def as_dict(self) -> dict[str, Any]:
        """Return the result for JSON."""
        return {
            "states": self.states,
            "cancels": sorted(self.cancels),
            "refusals": [asdict(refusal) for refusal in self.refusals.values()],
        }

    def __str__(self) -> str:
        head = f"  revision: tried in {counted(self.states, 'state')} in which the mission runs"
        lines = [head + ("" if self.refusals else ": can be applied in all of them")]
        lines += [
            f"    cancels the goal of '{name}' in some of them" for name in sorted(self.cancels)
        ]
        for refusal in self.refusals.values():
            lines.append(f"    refused in {counted(refusal.states, 'state')}: {refusal.reason}")
            lines += [f"      {number}. {step}" for number, step in enumerate(refusal.steps, 1)]
        return "\n".join(map(escape_control, lines))


TRIED, CANCELS, REFUSED = "tried", "cancels", "refused"
"""Names of what a state shows of a revision."""


class RevisionClaims(Claims):
    """Checks each state, and tries a revision in it.

    Args:
        before: The mission that is explored.
        after: The other version.
        result: Takes the results.
    """

    def __init__(self, before: Mission, after: Mission, result: RevisedEverywhere) -> None:
        super().__init__()
        self._before, self._after, self._result = before, after, result
        self._seen: set[int] = set()

    @override
    def look(self, environment: Environment) -> tuple[Broken, ...]:
        shown = super().look(environment)
        if environment.executive.status is not MissionStatus.RUNNING:
            return shown
        plan = RevisionPlan(environment.executive, environment, self._before, self._after)
        plan.build()
        revision = plan.preview()
        cancels = (Broken(CANCELS, name, name, "") for name in revision.cancels)
        refused = (Broken(REFUSED, reason, "", reason) for reason in revision.reasons)
        return (*shown, Broken(TRIED, "", "", ""), *cancels, *refused)

    @override
    def take(self, shown: tuple[Broken, ...], state: int, faults_left: float) -> None:
        ours = [broken for broken in shown if broken.name in (TRIED, CANCELS, REFUSED)]
        super().take(tuple(broken for broken in shown if broken not in ours), state, faults_left)
        if state in self._seen:
            return
        self._seen.add(state)
        for broken in ours:
            match broken.name:
                case "tried":
                    self._result.states += 1
                case "cancels":
                    self._result.cancels.add(broken.about)
                case _:
                    refusal = RevisionRefusal(broken.about, state=state)
                    self._result.refusals.setdefault(broken.about, refusal).states += 1
