"""What `bt-mission prove` takes: processor time, states a second, and memory of a state.

Parts: every shipped mission with usual answers and two faults; a checklist of pairs of a check and
an action, in the shape of BehaVerify's; a binary tree of checks with one invariant, of 1,031 and
2,055 nodes; Nav2's largest tree, written by hand, with one and with two faults.
Run it as: python benchmarks/commands/prove/proving.py [--seconds 60] [--missions NAME ...]
    [--pairs 50] [--leaves 512 1024]
"""

from __future__ import annotations

import resource
from collections.abc import Iterator
from pathlib import Path

from benchmarks.measuring import CpuWatch, arguments, figure, table
from bt_mission.commands.prove.explorer import Bounds
from bt_mission.commands.prove.proof import Proof, ProofOptions, prove
from bt_mission.language.mission import Mission
from bt_mission.sessions.load import load

ROOT = Path(__file__).resolve().parents[3]
SHIPPED = sorted(
    path.relative_to(ROOT / "missions").with_suffix("").as_posix()
    for folder in ("", "sources")
    for path in (ROOT / "missions" / folder).glob("*.yaml")
)


def checklist(pairs: int) -> str:
    """Return a sequence of fallbacks, each of a check that may fail and an action."""
    steps = [
        f"    - fallback:\n"
        f"        - {{check: 'uniform(0, 1) > 0.5', name: check {number}}}\n"
        f"        - {{turn: {{angle: {number}}}, timeout: 9, name: act {number}}}\n"
        for number in range(1, pairs + 1)
    ]
    return "mission: checklist\ntree:\n  sequence:\n" + "".join(steps)


def binary_tree(leaves: int) -> str:
    """Return a loop around a binary tree of checks on a number that each round makes larger.

    It has twice as many nodes as checks, and seven more. The invariant is that the number never
    passes the number of checks.
    """
    tree = "\n".join(_half(0, leaves, 10))
    return f"""\
mission: binary tree
requirements:
  never passes the last check: never $fish > {leaves}
tree:
  sequence:
    - set: {{fish: 0}}
    - repeat: {{until: fish >= {leaves}}}
      do:
        sequence:
          - fallback:
{tree}
          - set: {{fish: fish + 1}}
    - log: the biggest fish
    - wait: 0.1
    - log: the end
"""


def _half(first: int, count: int, depth: int) -> Iterator[str]:
    """Yield the lines of the children of a fallback over some checks."""
    pad = "  " * depth
    for start in (first, first + count // 2):
        if count == 2:
            yield f"{pad}  - check: fish == {start}"
        else:
            yield f"{pad}  - fallback:"
            yield from _half(start, count // 2, depth + 2)


def _measured(mission: Mission, faults: int, seconds: float) -> tuple[Proof, float, float]:
    """Return a proof, its processor time and the memory that it has added, kB."""
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    watch = CpuWatch()
    options = ProofOptions(faults=faults, bounds=Bounds(seconds=seconds))
    proof = prove(mission, options, lambda: watch.elapsed_s)
    return proof, watch.elapsed_s, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before


def main() -> None:
    """Measure the parts of the command line."""
    options = arguments(__doc__, seconds=60.0, missions=SHIPPED, pairs=50, leaves=[512, 1024])
    work = [
        (name.rpartition("/")[2], load(ROOT / "missions" / f"{name}.yaml"), 2)
        for name in options.missions
    ]
    shipped = len(work)
    work.append(("checklist", load(checklist(options.pairs)), 0))
    for leaves in options.leaves:
        mission = load(binary_tree(leaves))
        work.append((f"binary tree of {2 * leaves + 7}", mission, 0))
    nav2 = load(ROOT / "benchmarks" / "nav2_recovery.yaml")
    work += [("Nav2 with a fault", nav2, 1), ("Nav2 with two faults", nav2, 2)]
    proofs, times = [], []

    def rows() -> Iterator[tuple[object, ...]]:
        for name, mission, faults in work:
            proof, taken_s, more_kb = _measured(mission, faults, options.seconds)
            figure(f"{name}: processor time", taken_s, "s")
            proofs.append(proof)
            times.append(taken_s)
            yield (
                name,
                sum(1 for _ in mission.root.walk()),
                faults,
                f"{proof.states:,}",
                f"{taken_s:.2f}",
                f"{proof.states / max(taken_s, 1e-9):,.0f}",
                f"{1000 * more_kb / max(proof.states, 1):,.0f}",
                "; ".join(proof.why_not) or "exhaustive",
            )

    head = ("mission", "nodes", "faults", "states", "s", "states a second", "B a state", "result")
    table(head, rows())
    is_exhaustive = [not any("budget" in why for why in proof.why_not) for proof in proofs]
    share = sum(is_exhaustive[:shipped]) / max(shipped, 1)
    figure("shipped missions that are explored to the end", share)
    total = sum(proof.states for proof in proofs[:shipped]) / max(sum(times[:shipped]), 1e-9)
    figure("states a second", total)
    print(f"{share:.0%} of {shipped} shipped missions, {total:,.0f} states a second")


if __name__ == "__main__":
    main()
