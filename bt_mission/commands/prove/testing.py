"""Missions that a test proves: every answer of their servers is explored."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from bt_mission.commands.prove.answers import parse_answers
from bt_mission.commands.prove.explorer import Bounds
from bt_mission.commands.prove.proof import USUAL_FAULTS, Proof, ProofOptions
from bt_mission.commands.prove.proof import prove as explore
from bt_mission.language.expressions.values import Plain
from bt_mission.language.loader import required
from bt_mission.sessions.check import examine
from bt_mission.testing.stages import mission_file

__all__ = ["ProofFailed", "prove"]


class ProofFailed(AssertionError):  # noqa: N818 - its name stands in pytest's summary
    """A property of a mission does not hold, or not all of its states were visited."""


def prove(
    mission: str | Path,
    *,
    faults: float = USUAL_FAULTS,
    answers: str = "usual",
    interrupts: bool = False,
    rounds: int | None = None,
    states: int | None = None,
    inputs: Mapping[str, Plain] | None = None,
) -> Proof:
    """Explore every answer that the servers of a mission may give.

    ``prove("missions/explore.yaml", faults=1)``

    Args:
        mission: A file, the name of a shipped mission, or a mission as text (of several lines).
        faults: Most faults on a way; ``math.inf`` for no bound.
        answers: As ``--answers`` of ``bt-mission prove``.
        interrupts: Consider Ctrl-C at any time, too.
        rounds: Counts of `repeat` above it are cut to it.
        states: The exploration fails with more states.
        inputs: Values of the mission's inputs.

    Raises:
        ProofFailed: With the findings as text, each with a shortest sequence of answers.
        InputError: With every error of the mission.
    """
    text = str(mission)
    source = text if "\n" in text else mission_file(mission)
    options = ProofOptions(
        faults=faults,
        answers=parse_answers(answers),
        with_interrupts=interrupts,
        rounds=rounds,
        bounds=Bounds(states=states),
    )
    proof = explore(required(examine(source, set=dict(inputs or {}), servers=None)), options)
    if failed := [*proof.not_exercised, *proof.findings]:
        raise ProofFailed("\n".join([f"{proof.mission}:", *map(str, failed)]))
    if not (proof.proved or proof.not_violated):
        raise ProofFailed(f"{proof.mission}: not explored to the end: {'; '.join(proof.why_not)}")
    return proof
