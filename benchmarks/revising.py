"""The delay of a tick by a revision of a running mission, by its size.

Every leaf has a goal under way, and there is a viewer. Two versions take turns: the second one has
one more leaf, and a time limit around another one. `bt-mission revise` has the executive read the
new version, prepare the new tree and exchange the trees, each just after a tick. Reading is
measured by `benchmarks check`. The preparation compares the versions and builds the new tree. The
mission is ticked once before the exchange, and the goals continue. The new tree is sent after the
next tick.
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
            prepared, taken, tick, sent = [], [], [], []
            for version, _ in zip(cycle((other, plain)), range(2 * options.rounds), strict=False):
                tick.append(1e3 * tree.ours())
                watch = CpuWatch()
                plan = tree.runner.plan_revision(version)
                plan.build(tree.runner.revising.emit)
                prepared.append(1e3 * watch.elapsed_s)
                tree.ours()
                watch = CpuWatch()
                revision = tree.runner.apply_revision(plan)
                taken.append(1e3 * watch.elapsed_s)
                assert revision.is_applied, revision.reasons
                assert len(revision.continues) == goals, "no goal is touched"
                watch = CpuWatch()
                tree.runner.status_publisher.publish_if_changed()
                sent.append(1e3 * watch.elapsed_s)
        figure(f"{nodes} nodes: a revision", taken, "ms")
        figure(f"{nodes} nodes: its preparation", prepared, "ms")
        figure(f"{nodes} nodes: sending its tree", sent, "ms")
        figure(f"{nodes} nodes: a revision in ticks", ratios(taken, tick))
        times = (spread(values, 2) for values in (prepared, taken, sent, tick))
        rows.append([tree.size, *times, spread(ratios(taken, tick), 1)])
    print(f"### A revision while every leaf runs (a tick is the mean of {TICKS})\n")
    head = ("nodes", "preparation, ms", "exchange, ms", "sending, ms", "a tick, ms")
    table((*head, "exchange in ticks"), rows)


if __name__ == "__main__":
    main()
