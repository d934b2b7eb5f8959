"""Proofs against runs: what a run shows although it is proved that no run does."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field

from bt_mission.commands.prove.explorer import Bounds
from bt_mission.commands.prove.proof import Proof, ProofOptions, prove
from bt_mission.language.mission import Mission
from tests.commands.prove.oracle.world import World

MOST_STATES = 3000


@dataclass(frozen=True)
class Defect:
    """A claim of a proof that a run breaks.

    Attributes:
        claim: The property that is proved, the requirement, or the node that is never entered.
        seed: Of the run.
        why: What the run shows, with its time.
        history: What happens in it.
    """

    claim: str
    seed: int
    why: str
    history: tuple[str, ...] = field(repr=False)


@dataclass
class Trial:
    """A mission with its proof and its runs."""

    proof: Proof
    runs: int = 0
    void: Counter[str] = field(default_factory=Counter)
    defects: dict[str, Defect] = field(default_factory=dict)


def proof_of(mission: Mission, faults: float, most_states: int) -> Proof:
    """Prove a mission."""
    return prove(mission, ProofOptions(faults=faults, bounds=Bounds(states=most_states)))


def claims_of(proof: Proof) -> dict[str, str]:
    """Return what a proof rules out: what a run notes, and the claim."""
    claims = {name: f"proved: {name}" for name in proof.proved}
    for entry in proof.requirements:
        name = entry.requirement
        if entry.verdict == "proved":
            claims[f"requirement {name}"] = f"proved: requirement {name}"
        elif entry.verdict in ("not exercised", "not applicable") and proof.exhaustive:
            claims[f"exercised {name}"] = f"{entry.verdict}: requirement {name}"
    if proof.exhaustive:
        for name in proof.never_entered:
            claims[f"entered {name}"] = f"never entered: {name}"
    return claims


def shown_by(world: World) -> Iterator[tuple[str, str]]:
    """Yield what a run shows, with the reason."""
    yield from world.broken.items()
    yield from ((f"entered {name}", f"'{name}' is entered") for name in world.entered)


def try_mission(
    mission: Mission,
    text: str,
    faults: int,
    runs: int,
    *,
    only: str | None = None,
    most_states: int = MOST_STATES,
) -> Trial:
    """Prove a mission and run it; return what the runs break.

    Args:
        only: The claim to look at; None for all. The first run that breaks it is the last one.
    """
    trial = Trial(proof_of(mission, faults, most_states))
    claims = claims_of(trial.proof)
    if only is not None:
        claims = {name: claim for name, claim in claims.items() if claim == only}
    for seed in range(runs if claims else 0):
        world = World(mission, text, seed, faults).run()
        trial.runs += 1
        if world.void:
            trial.void[world.void] += 1
            continue
        for name, why in shown_by(world):
            claim = claims.get(name)
            if claim is not None and claim not in trial.defects:
                trial.defects[claim] = Defect(claim, seed, why, tuple(world.history))
        if only in trial.defects:
            break
    return trial
