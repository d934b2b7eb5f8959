"""Attached missions whose processes are killed, stopped and restarted at random instants.

Run it as: python campaigns/attached_campaign.py [--count 200] [--results attached.jsonl]

Trial N follows from the number N alone: a mission, whether an arbiter is in front of the base,
whether the executive is `run` or `serve`, and one or two of kill (for good), stop (SIGSTOP, then
SIGCONT) and restart, of executive, servers, arbiter or simulator, at an instant of the first
seconds. Processes run at the speed of the wall clock, so a repeated trial is a similar one, not the
same. Each trial is one line of the results; a second run goes on where the first was stopped. A
finding is

- a base that does not stand within 0.5 s of ROS time after the last command that moves it was sent,
  once the chain from executive to base is broken, or that moves at the end,
- a goal that the servers still carry out when the executive is gone, or that it reports as orphaned
  and does not name,
- an exit code, or a number of goals that succeeded, that is not true,
- a journal that is neither carried on nor refused with a reason,
- a traceback in the output of any process, a process that does not end, a process that is left.

``--show N`` prints trial N. ``KEEP_OUTPUT=FOLDER`` keeps the output of trials with findings.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import statistics
from collections import Counter
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import asdict
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from attached_plan import plan
from attached_trial import Trial, carry_out
from campaign import pending

from benchmarks.measuring import figure, table
from bt_mission.testing.live_graph import LOCAL, own_domain

_DOMAIN = ExitStack()


def join_a_domain() -> None:
    """Give this process and its children a separate domain."""
    domain_id = _DOMAIN.enter_context(own_domain())
    os.environ.update({"ROS_DOMAIN_ID": str(domain_id), **LOCAL})
    # A shell starts background processes with Ctrl-C ignored, and so are their children.
    signal.signal(signal.SIGINT, signal.default_int_handler)


def main() -> None:
    """Run the campaign."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--results", type=Path, default=Path("attached.jsonl"))
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--only", type=int, nargs="+", metavar="N", help="these trials again")
    parser.add_argument("--show", type=int, metavar="N", help="print trial N, and run nothing")
    options = parser.parse_args()
    if options.show is not None:
        print(plan(options.show))
        return
    options.results.touch()
    todo = options.only or pending(options.results, options.count)
    with (
        options.results.open("a") as results,
        get_context("spawn").Pool(options.jobs, initializer=join_a_domain) as pool,
    ):
        for outcome in pool.imap_unordered(carry_out, todo):
            results.write(json.dumps(asdict(outcome)) + "\n")
            results.flush()
            report(outcome)
    summarise([json.loads(line) for line in options.results.read_text().splitlines()])


def report(outcome: Trial) -> None:
    """Print a line for a trial, and one for each finding."""
    print(f"{outcome.number}: {outcome.plan}: {outcome.ended} {outcome.reason}", flush=True)
    for finding in outcome.findings:
        print(f"    {finding}", flush=True)


def summarise(trials: list[dict[str, Any]]) -> None:
    """Print the figures of a campaign."""
    figure("findings", sum(len(line["findings"]) for line in trials))
    kinds = Counter(finding.partition(":")[0] for line in trials for finding in line["findings"])
    loads = [line["load"] for line in trials]
    hours = sum(line["wall_s"] for line in trials) / 3600
    resumed = Counter(line["resumed"].split(",")[0].split(":")[0] for line in trials)
    print(
        f"{len(trials)} trials in {hours:.1f} h, load {min(loads):.0f} to {max(loads):.0f} "
        f"(median {statistics.median(loads):.0f}); from journals: {dict(resumed)}; "
        f"findings: {dict(kinds) or 'none'}\n"
    )
    head = ("disturbance", "trials", "base drove", "stands after the disturbance")
    table((*head, "after the last command sent", "within 0.5 s of each"), rows(trials))


def rows(trials: list[dict[str, Any]]) -> Iterator[tuple[object, ...]]:
    """Yield a row for each kind of disturbance of a process."""
    done = Counter(disturbance for line in trials for disturbance in line["disturbed"])
    for name, count in sorted(done.items()):
        figures = [stand[1:] for line in trials for stand in line["stood"] if stand[0] == name]
        if not figures:
            yield name, count, 0, "", "", ""
            continue
        yield (
            name,
            count,
            len(figures),
            *(
                f"{statistics.median(column):.2f} s, at most {max(column):.2f} s"
                for column in zip(*figures, strict=True)
            ),
            ", ".join(
                str(sum(value <= 0.5 + 1e-6 for value in column))
                for column in zip(*figures, strict=True)
            ),
        )


if __name__ == "__main__":
    main()
