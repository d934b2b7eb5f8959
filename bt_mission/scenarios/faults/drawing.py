"""Random faults: of every kind, at drawn times, each of limited duration."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from bt_mission.base.diagnostics import did_you_mean, quoted
from bt_mission.requirements.language.formula import Condition
from bt_mission.scenarios.draws import Draws, maybe, number, one_of
from bt_mission.scenarios.faults.drawable import STEP_S, Drawable
from bt_mission.scenarios.faults.faults import FAULTS
from bt_mission.scenarios.faults.kind import FaultKind
from bt_mission.scenarios.faults.planned import AtTime, Beginning, PlannedFault, WhenTrue
from bt_mission.scenarios.faults.values import planned_fault
from bt_mission.scenarios.faults.world import OF_A_BOX

MOST_DIAGNOSTICS = 5
SILENCES_ONE_IN = 3
"""As often, where the mission trusts a topic, that falls silent."""
SILENCING = ("drop", "freeze")
"""The faults after which a topic has no new value, the simplest first."""
LONGEST_HELD_S = 3.0
"""An event has been true for so long at most when a fault begins, s."""

GROUPS: Mapping[str, tuple[str, ...]] = {
    group: tuple(injectable.name for injectable in FAULTS.values() if injectable.group == group)
    for group in dict.fromkeys(injectable.group for injectable in FAULTS.values())
    if group
}
"""The faults of each group; the first is the simplest."""

DEFAULT_KINDS = ("network", "hardware", "servers", "messages")
"""Groups that faults are drawn from where the ranges name none; those of the camera and the battery
besides, where the mission uses them."""

GRAPH_FAULTS = (
    "drop",
    "delay",
    "duplicate",
    "freeze",
    "corrupt",
    "reject_goals",
    "delay_answers",
    "delay_results",
    "refuse_cancels",
    "slow_server",
    "silence_feedback",
)
"""Some faults of topics and of goals on their way: none touches the robot, or code."""


def unknown_kind(name: str) -> tuple[str, str | None] | None:
    """Return what is wrong with the name of a kind or group, and a hint; None if it is one."""
    if name in GROUPS or (name in FAULTS and FAULTS[name].group):
        return None
    if name in FAULTS:
        return f"{quoted(name)}: obstacles have separate ranges, 'obstacles:'", None
    near = did_you_mean(name, (*GROUPS, *(kind.name for kind in FAULTS.values() if kind.group)))
    known = None if near else f"groups: {', '.join(GROUPS)}; or the name of a fault"
    return f"unknown fault {quoted(name)}", near or known


def faults_of(kinds: Iterable[str]) -> tuple[str, ...]:
    """Return the faults of kinds and groups, each once."""
    return tuple(dict.fromkeys(name for kind in kinds for name in GROUPS.get(kind, (kind,))))


def drawn_faults(
    draws: Draws, names: Sequence[str] = (), leaves: Sequence[str] = ()
) -> tuple[PlannedFault, ...]:
    """Return some random faults, each of limited duration; a run may end before they begin.

    Args:
        names: Of faults; by default those of topics, goals and feedback.
        leaves: Names or paths of leaves in which exceptions may be raised.
    """
    count = draws.whole(0, MOST_DIAGNOSTICS)
    drawable = Drawable(names or GRAPH_FAULTS, leaves)
    drawn = (fault for _ in range(count) for fault in drawn_fault(draws, drawable))
    return tuple(replace(fault, may_not_happen=True) for fault in drawn)


def can_be_drawn(name: str, drawable: Drawable) -> bool:
    """Tell whether there is anything that a fault could be about."""
    kind = FAULTS[name]
    needed: dict[str, Sequence[Any]] = {"leaf": drawable.leaves, "service": drawable.services}
    if kind.needs_fields and not drawable.fields_of(name):
        return False
    return all(
        needed.get(parameter.names, True)
        for parameter in kind.parameters.values()
        if parameter.is_required
    )


def drawn_fault(draws: Draws, drawable: Drawable) -> tuple[PlannedFault, ...]:
    """Return a random fault, and what it needs before it."""
    begins = drawn_beginning(draws, drawable)
    silencing = [name for name in SILENCING if name in drawable.names]
    if drawable.trusted and silencing and maybe(draws, SILENCES_ONE_IN):
        return (_drawn_silence(begins, silencing, draws, drawable),)
    kind = FAULTS[one_of(draws, drawable.names)]
    fault = planned_fault(begins, kind.name, **_drawn_arguments(kind, draws, drawable))
    if kind.name in OF_A_BOX:
        return (planned_fault(begins, "spawn_box", 1.0, 0.0, nearest_free=True), fault)
    return (fault,)


def _drawn_silence(
    begins: Beginning, names: Sequence[str], draws: Draws, drawable: Drawable
) -> PlannedFault:
    """Draw a silence of a topic that the mission trusts, for about as long as it may be."""
    topic = one_of(draws, tuple(drawable.trusted))
    periods = drawable.trusted[topic]
    lasting = (
        one_of(draws, periods) if periods else drawable.period(draws, *drawable.lasting, STEP_S)
    )
    return planned_fault(begins, one_of(draws, names), topic=topic, lasting=lasting)


def drawn_beginning(draws: Draws, drawable: Drawable) -> Beginning:
    """Draw when a fault begins: at the first time, at any, or with an event."""
    time = number(draws, *drawable.times, STEP_S)
    time = drawable.times[0] if maybe(draws, 4) else time
    if not drawable.events or not maybe(draws, 2):
        return AtTime(time)
    held = number(draws, 0, LONGEST_HELD_S, STEP_S) if maybe(draws, 2) else 0.0
    return WhenTrue(Condition(one_of(draws, drawable.events)), held)


def _drawn_arguments(kind: FaultKind, draws: Draws, drawable: Drawable) -> dict[str, Any]:
    if kind.draw is not None:
        given = dict(kind.draw(draws, drawable))
    else:
        given = {
            parameter.name: parameter.drawn(draws, drawable)
            for parameter in kind.declared
            if parameter.drawn
        }
    if kind.lasts and not kind.waits:
        given["lasting"] = drawable.period(draws, *drawable.lasting, STEP_S)
    return given
