"""The delay of a tick by a revision of a running mission, by its size.

Every leaf has a goal under way, and there is a viewer. Two versions take turns: the second one has
one more leaf, and a time limit around another one. A revision compares the versions, builds the new
tree, exchanges the trees, and sends the new one; the goals continue. The new version is loaded
before, as `bt-mission revise` has the executive do between two ticks.
Run it as: python benchmarks/revising.py [--rounds N] [--nodes N]
"""

from __future__ import annotations

import argparse
import json
from itertools import cycle

from measuring import CpuWatch, figure, ratios, spread, table
from ticks import ALL_RUN, TICKS, step_of, ticked

from bt_mission.core.dds.discovery import isolate
from bt_mission.language.mission import Mission
from bt_mission.sessions.load import load

SIZES = (100, 300, 1000)


def versions(nodes: int) -> tuple[Mission, Mission]:
    """Return a mission of some nodes, and another version of it."""
    head = {"mission": "ticked", "inputs": {"battery": 0.9, "is_ready": True}}
    tree = step_of(ALL_RUN, nodes)
    other = json.loads(json.dumps(tree))
    box = other["parallel"]
    while "parallel" in box[0]:
        box = box[0]["parallel"]
    box[0] = {"timeout": 3600, "do": box[0]}
    other["parallel"].append({"wait": 3600})
    first, second = (load(json.dumps({**head, "tree": steps})) for steps in (tree, other))
    return first, second


def main() -> None:
    """Print the table."""
    assert __doc__ is not None
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--nodes", type=int, default=SIZES[-1], help="of the largest tree")
    options = parser.parse_args()
    isolate(visible=False)
    rows = []
    for nodes in (size for size in SIZES if size <= options.nodes):
        plain, other = versions(nodes)
        with ticked(ALL_RUN, nodes) as tree:
            goals = len(tree.runner.ledger.open_goals)
            taken, tick = [], []
            for version, _ in zip(cycle((other, plain)), range(2 * options.rounds), strict=False):
                tick.append(1e3 * tree.ours())
                watch = CpuWatch()
                revision = tree.runner.revise(version)
                taken.append(1e3 * watch.elapsed_s)
                assert revision.is_applied, revision.reasons
                assert len(revision.continues) == goals, "no goal is touched"
        figure(f"{nodes} nodes: a revision", taken, "ms")
        figure(f"{nodes} nodes: a revision in ticks", ratios(taken, tick))
        rows.append([tree.size, spread(taken, 2), spread(tick, 2), spread(ratios(taken, tick), 1)])
    print(f"### A revision while every leaf runs (a tick is the mean of {TICKS})\n")
    table(("nodes", "a revision, ms", "a tick, ms", "a revision in ticks"), rows)


if __name__ == "__main__":
    main()
