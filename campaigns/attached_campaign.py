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

import os
import signal
import statistics
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import attached_trial
from attached_plan import plan
from trials import Line, carry_out, conclude, counted, missing

from benchmarks.measuring import arguments, table
from bt_mission.testing.live_graph import LOCAL, own_domain

_DOMAIN = ExitStack()


def join_a_domain() -> None:
    """Give this process and its children a separate domain."""
    domain_id = _DOMAIN.enter_context(own_domain())
    os.environ.update({"ROS_DOMAIN_ID": str(domain_id), **LOCAL})
    # A shell starts background processes with Ctrl-C ignored, and so are their children.
    signal.signal(signal.SIGINT, signal.default_int_handler)


def rows(trials: list[Line]) -> Iterator[tuple[object, ...]]:
    """Yield a row for each kind of disturbance of a process."""
    done = counted(disturbance for line in trials for disturbance in line["disturbed"])
    for name, count in sorted(done.items()):
        figures = [stand[1:] for line in trials for stand in line["stood"] if stand[0] == name]
        columns = list(zip(*figures, strict=True)) or [(), ()]
        yield (
            name,
            count,
            len(figures),
            *(
                f"{statistics.median(column):.2f} s, at most {max(column):.2f} s" if column else ""
                for column in columns
            ),
            ", ".join(str(sum(value <= 0.5 + 1e-6 for value in column)) for column in columns),
        )


def main() -> None:
    """Run the campaign."""
    options = arguments(
        __doc__,
        count=200,
        results=Path("attached.jsonl"),
        jobs=2,
        only=([0], "these trials again"),
        show=(None, "print trial N, and run nothing"),
    )
    if options.show is not None:
        print(plan(options.show))
        return
    todo = missing(options.results, options.count) if options.only == [0] else options.only
    lines = carry_out(attached_trial.carry_out, todo, options.results, options.jobs, join_a_domain)
    for line in lines:
        print(f"{line['number']}: {line['plan']}: {line['ended']} {line['reason']}")
    loads = [line["load"] for line in lines]
    hours = sum(line["wall_s"] for line in lines) / 3600
    resumed = counted(line["resumed"].split(",")[0].split(":")[0] for line in lines)
    head = ("disturbance", "trials", "base drove", "stands after the disturbance")
    table((*head, "after the last command sent", "within 0.5 s of each"), rows(lines))
    conclude(
        lines,
        f"{len(lines)} trials in {hours:.1f} h, load {min(loads):.0f} to {max(loads):.0f} "
        f"(median {statistics.median(loads):.0f}); from journals: {resumed}",
    )


if __name__ == "__main__":
    main()
