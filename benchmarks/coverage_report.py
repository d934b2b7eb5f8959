"""Table and plot of the runs of coverage.py, written into docs/."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Protocol

import matplotlib as mpl
import numpy as np

mpl.use("Agg")

import matplotlib.pyplot as plt
from matplotlib.axes import Axes

PAGE = Path("docs/explanation/exploration.md")
PLOT = Path("docs/images/coverage.png")
BEGIN, END = "<!-- coverage: begin -->", "<!-- coverage: end -->"

# Wong, "Points of view: Color blindness", Nature Methods 2011: told apart by everybody.
STYLE = {
    "fixed": ("fixed turn", "#999999"),
    "random": ("random turn (Brownian)", "#E69F00"),
    "levy": ("Lévy flight", "#CC79A7"),
    "informed": ("informed turn", "#0072B2"),
    "frontiers": ("frontiers of the map", "#009E73"),
}
MARKS_S = (30, 60, 120, 180)
GOAL = 0.9


class Run(Protocol):
    """What is needed of a run."""

    strategy: str
    world: str
    seed: int
    collisions: int
    driven: float
    ended_s: float
    floor: list[float]
    zones: list[int]


def write_report(runs: Sequence[Run], areas: Mapping[str, float]) -> None:
    """Draw the plot, and put the tables between the marks of the page. `areas` are in m²."""
    draw(runs, areas)
    tables = "\n".join(table([run for run in runs if run.world == w], w, areas[w]) for w in areas)
    text = PAGE.read_text(encoding="utf-8")
    before, rest = text.split(BEGIN)
    after = rest.split(END)[1]
    PAGE.write_text(f"{before}{BEGIN}\n{tables}{END}{after}", encoding="utf-8")


def table(runs: Sequence[Run], world: str, area: float) -> str:
    """One world's figures in Markdown."""
    seeds = sorted({run.seed for run in runs})
    head = [f"floor at {mark} s" for mark in MARKS_S]
    head = ["strategy", *head, f"{100 * GOAL:.0f} % of the floor after"]
    head += [f"zones at {MARKS_S[-1]} s", "driven", "collisions"]
    lines = [
        f"### {world}, {area:.1f} m² of floor, seeds {seeds[0]} to {seeds[-1]}",
        "",
        f"| {' | '.join(head)} |",
        "|" + "---|" * len(head),
    ]
    for strategy, (label, _) in STYLE.items():
        own = [run for run in runs if run.strategy == strategy]
        floor = 100.0 * np.array([run.floor for run in own])
        shares = "".join(f" {spread(floor[:, mark - 1])} % |" for mark in MARKS_S)
        lines.append(
            f"| {label} |{shares} {reached(own)} | {spread([run.zones[-1] for run in own])} "
            f"| {np.median([run.driven for run in own]):.0f} m "
            f"| {sum(run.collisions for run in own)} |"
        )
    return "\n".join(lines) + "\n"


def spread(values: Sequence[float] | np.ndarray) -> str:
    """The median, and the quartiles in brackets."""
    low, middle, high = np.percentile(values, (25, 50, 75))
    return f"**{middle:.0f}** ({low:.0f} to {high:.0f})"


def reached(runs: Sequence[Run]) -> str:
    """When 90 % of the floor were known: the median, or how many runs got there."""
    times = [
        next((i + 1 for i, share in enumerate(run.floor) if share >= GOAL), np.inf) for run in runs
    ]
    there = int(np.isfinite(times).sum())
    middle = float(np.percentile(times, 50, method="higher"))
    if there == len(runs):
        return f"**{middle:.0f} s**"
    if np.isfinite(middle):
        return f"**{middle:.0f} s**, {there} of {len(runs)} runs"
    return f"{there} of {len(runs)} runs" if there else "never"


def draw(runs: Sequence[Run], areas: Mapping[str, float]) -> None:
    """Floor and zones against time, a column for each world."""
    plt.rcParams.update({"font.size": 10, "font.family": "DejaVu Sans", "axes.titlesize": 11})
    figure, panels = plt.subplots(
        2, len(areas), figsize=(5.2 * len(areas), 6.6), sharex=True, squeeze=False
    )
    for column, (world, area) in enumerate(areas.items()):
        here = [run for run in runs if run.world == world]
        upper, lower = panels[0, column], panels[1, column]
        upper.set_title(f"{world}   ({area:.0f} m² of floor)", loc="left", fontweight="bold")
        for strategy in STYLE:
            own = [run for run in here if run.strategy == strategy]
            band(upper, 100.0 * np.array([run.floor for run in own]), strategy)
            band(lower, np.array([run.zones for run in own], dtype=float), strategy)
        upper.set_ylim(0, 102)
        lower.set_ylim(bottom=0)
        lower.set_xlabel("virtual time, s")
        lower.set_xlim(0, len(here[0].floor))
        lower.set_xticks(range(0, len(here[0].floor) + 1, 30))
    panels[0, 0].set_ylabel("floor known, %")
    panels[1, 0].set_ylabel("1 m zones visited")
    handles, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(
        handles, labels, loc="lower center", ncols=len(STYLE), frameon=False, columnspacing=1.4
    )
    figure.tight_layout(rect=(0, 0.045, 1, 1))
    PLOT.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(PLOT, dpi=130)
    plt.close(figure)


def band(axes: Axes, values: np.ndarray, strategy: str) -> None:
    """The median of many runs over time, with the quartiles as a band around it."""
    label, colour = STYLE[strategy]
    low, middle, high = np.percentile(values, (25, 50, 75), axis=0)
    seconds = np.arange(1, values.shape[1] + 1)
    front = 3 if strategy == "frontiers" else 2
    axes.fill_between(seconds, low, high, color=colour, alpha=0.15, linewidth=0, zorder=1)
    axes.plot(seconds, middle, color=colour, linewidth=2, label=label, zorder=front)
    axes.grid(color="#dddddd", linewidth=0.6)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
