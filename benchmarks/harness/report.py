"""What was measured, as tables in Markdown and as JSON."""

from __future__ import annotations

import math
import os
import platform
from collections.abc import Iterable, Iterator, Sequence
from importlib import metadata
from pathlib import Path
from typing import Any

from benchmarks.harness.benchmark import Aim, Figure, Target
from benchmarks.harness.measurement import Measurement, Spread, Values
from benchmarks.harness.running import Plan

FORMAT = 1
"""Of the JSON; it grows when a key changes its meaning."""

REACHED = {True: "yes", False: "**no**", None: ""}


# ---- Markdown --------------------------------------------------------------------------------


def markdown(lines: Sequence[str], measurements: Sequence[Measurement], plan: Plan) -> str:
    """Return one table of all figures.

    Args:
        lines: Said before it, of the machine.
        measurements: What was measured.
        plan: What was compared.
    """
    versions = (plan.old.commit, plan.new.commit, "new to old") if plan.old else (plan.new.commit,)
    head = ("benchmark", "figure", *versions, "target", "reached")
    rows = [
        (
            one.benchmark.name,
            values.name,
            *_cells(values, compared=plan.old is not None),
            _target_text(_target(one, values)),
            REACHED[values.is_met(_target(one, values))],
        )
        for one in measurements
        for values in one.figures.values()
    ]
    return _page(lines, head, rows, measurements)


def step_table(lines: Sequence[str], measurements: Sequence[Measurement], plan: Plan) -> str:
    """Return the table of the figures that have a row of their own, with what they must come to."""
    versions = (plan.old.commit, plan.new.commit, "new to old") if plan.old else (plan.new.commit,)
    head = ("what", *versions, "must", "aim", "reached")
    rows = []
    for one in measurements:
        for values in one.figures.values():
            figure = one.benchmark.figure(values.name)
            if figure is None or not figure.row:
                continue
            target = figure.target or Target(Aim.AT_MOST)
            bounds = (_bound(target, target.must), _bound(target, target.aim))
            cells = _cells(values, compared=plan.old is not None)
            reached = REACHED[values.is_met(target)]
            rows.append((_row_name(figure, values), *cells, *bounds, reached))
    return _page(lines, head, rows, measurements)


def _page(
    lines: Sequence[str],
    head: Sequence[str],
    rows: Iterable[Sequence[str]],
    measurements: Iterable[Measurement],
) -> str:
    table = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    table += ["| " + " | ".join(row) + " |" for row in rows]
    remarks = list(_remarks(measurements))
    return "\n".join([*lines, "", *table, *([""] if remarks else []), *remarks]) + "\n"


def _remarks(measurements: Iterable[Measurement]) -> Iterator[str]:
    for one in measurements:
        if one.old_lacks:
            yield f"- {one.benchmark.name}: {one.old_lacks}"
        if one.old_script:
            yield f"- {one.benchmark.name}: the old commit was measured by its own script"
        for failure in one.failures:
            yield f"- {one.benchmark.name} FAILED: {failure.splitlines()[0].removesuffix(':')}"


def _cells(values: Values, *, compared: bool) -> list[str]:
    new = Spread.of(values.new).text(values.unit) if values.new else "none"
    if not compared:
        return [new]
    old = Spread.of(values.old).text(values.unit) if values.old else "none"
    return [old, new, Spread.of(values.ratios).text() if values.ratios else ""]


def _row_name(figure: Figure, values: Values) -> str:
    """Name a row; what the pattern leaves open stands behind it."""
    before, star, after = figure.name.partition("*")
    open_part = values.name.removeprefix(before).removesuffix(after) if star else ""
    return f"{figure.row}: {open_part}" if open_part else figure.row


def _target(measurement: Measurement, values: Values) -> Target | None:
    figure = measurement.benchmark.figure(values.name)
    return figure.target if figure else None


def _bound(target: Target, value: float | None) -> str:
    if value is None:
        return ""
    sign = "at least" if target.kind is Aim.AT_LEAST else "at most"
    return f"{sign} {value:g}{' x old' if target.kind is Aim.OF_OLD else ''}"


def _target_text(target: Target | None) -> str:
    if target is None:
        return ""
    must, aim = _bound(target, target.must), _bound(target, target.aim)
    return must + (f" (aim: {aim})" if must else f"aim: {aim}") * bool(aim)


# ---- JSON ------------------------------------------------------------------------------------


def document(
    measurements: Sequence[Measurement], plan: Plan, machine: dict[str, Any]
) -> dict[str, Any]:
    """Return all that was measured, for a file of JSON."""
    return {
        "format": FORMAT,
        "commit": plan.new.commit,
        "against": plan.old.commit if plan.old else None,
        "smoke": plan.smoke,
        "machine": machine,
        "benchmarks": [
            {
                "name": one.benchmark.name,
                "line": one.benchmark.line,
                "seconds": round(one.seconds, 3),
                "failures": one.failures,
                "old_lacks": one.old_lacks or None,
                "old_script": one.old_script,
                "figures": [_figure(one, values) for values in one.figures.values()],
            }
            for one in measurements
        ],
    }


def _figure(measurement: Measurement, values: Values) -> dict[str, Any]:
    target = _target(measurement, values)
    return {
        "name": values.name,
        "unit": values.unit,
        "new": _summary(values.new),
        "old": _summary(values.old),
        "ratio": _summary(values.ratios),
        "target": target and {"kind": target.kind.value, "must": target.must, "aim": target.aim},
        "reached": values.is_met(target),
    }


def _summary(values: Sequence[float]) -> dict[str, Any] | None:
    if not values:
        return None
    spread = Spread.of(values)
    return {
        "median": _finite(spread.median),
        "least": _finite(spread.least),
        "most": _finite(spread.most),
        "values": [_finite(one) for one in values],
    }


def _finite(value: float) -> float | None:
    """What JSON can hold: a base that never stands does so after infinity."""
    return value if math.isfinite(value) else None


# ---- the machine -----------------------------------------------------------------------------


def about_machine(busy: int) -> dict[str, Any]:
    """What the figures depend on.

    Args:
        busy: Processes that compute beside the benchmarks.
    """
    return {
        "processor": _processor(),
        "cores": len(os.sched_getaffinity(0)),
        "python": platform.python_version(),
        "mujoco": metadata.version("mujoco"),
        "numpy": metadata.version("numpy"),
        "busy": busy,
        "load_before": round(os.getloadavg()[0], 2),
    }


def _processor() -> str:
    for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
        name, _, value = line.partition(":")
        if name.strip() == "model name":
            return value.strip()
    return platform.machine()


def machine_lines(machine: dict[str, Any], plan: Plan) -> list[str]:
    """Say in Markdown where and of what the figures are."""
    of = f"{plan.new.commit} against {plan.old.commit}, in turns" if plan.old else plan.new.commit
    load = f"load {machine['load_before']} before, {machine['load_after']} after"
    beside = f", {machine['busy']} processes computing beside it" if machine["busy"] else ""
    tiny = ["**A smoke: tiny runs, whose figures mean nothing.**", ""] if plan.smoke else []
    where = f"{machine['cores']} x {machine['processor']}, Python {machine['python']}"
    said = f"{of}; medians, in brackets the spread. {where}, MuJoCo {machine['mujoco']}"
    return [*tiny, f"{said}; {load}{beside}."]
