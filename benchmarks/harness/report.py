"""The measurements, as a table in Markdown."""

from __future__ import annotations

import os
import platform
import statistics
from collections.abc import Sequence
from importlib import metadata
from pathlib import Path

from benchmarks.harness.catalogue import Target
from benchmarks.harness.running import Figure, Measurement, Plan
from benchmarks.measuring import spread


def is_reached(figure: Figure, target: Target | None) -> bool | None:
    """Return whether a target is reached; None without a target or a value."""
    values = figure.ratios if target and target.of_old else figure.new
    return target.is_met(statistics.median(values)) if target and values else None


def markdown(
    measurements: Sequence[Measurement], plan: Plan, machine: str, *, with_target: bool = False
) -> str:
    """Return the figures as a table; `with_target` only those that have one."""
    commits = (plan.old.commit, plan.new.commit, "new to old") if plan.old else (plan.new.commit,)
    rows: list[Sequence[str]] = [("benchmark", "figure", *commits, "target", "reached")]
    rows.append(["---"] * len(rows[0]))
    remarks = []
    for measurement in measurements:
        for name, figure in measurement.figures.items():
            target = measurement.benchmark.target(name)
            if target is None and with_target:
                continue
            values = [spread(figure.new, figure.unit)]
            if plan.old:
                values = [spread(figure.old, figure.unit), *values, spread(figure.ratios)]
            reached = {True: "yes", False: "**no**", None: ""}[is_reached(figure, target)]
            rows.append((measurement.benchmark.name, name, *values, str(target or ""), reached))
        remarks += (
            [f"- {measurement.benchmark.name}: {measurement.remark}"] if measurement.remark else []
        )
        remarks += [
            f"- {measurement.benchmark.name} FAILED: {text.splitlines()[0]}"
            for text in measurement.failures
        ]
    table = [f"| {' | '.join(row)} |" for row in rows]
    return "\n".join([machine, "", *table, "", *remarks]).rstrip("\n") + "\n"


def machine_line(plan: Plan, load_before: float, busy: int) -> str:
    """Return which commits were measured, and on which machine."""
    commits = (
        f"{plan.new.commit} against {plan.old.commit}, in turns" if plan.old else plan.new.commit
    )
    models = (
        line.partition(":")[2].strip()
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        if line.startswith("model name")
    )
    processor = next(models, platform.machine())
    smoke = "A smoke, whose figures mean nothing: " if plan.smoke else ""
    beside = f", {busy} processes computing beside it" if busy else ""
    return (
        f"{smoke}{commits}; medians, in brackets the spread. {len(os.sched_getaffinity(0))} x "
        f"{processor}, Python {platform.python_version()}, MuJoCo {metadata.version('mujoco')}; "
        f"load {load_before:.1f} before, {os.getloadavg()[0]:.1f} after{beside}."
    )
