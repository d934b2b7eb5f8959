#!/usr/bin/env python3
"""Draw where the time of a step goes, before and after: docs/images/step.svg.

Takes what ``python -m benchmarks shares --against REV --json FILE`` has written, which has both, or
two files of ``python benchmarks/shares.py --json FILE``, the older one first:

    python tools/draw_shares.py FILE [FILE] [-o PICTURE]
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

import matplotlib as mpl

mpl.use("svg")

import matplotlib.pyplot as plt

PICTURE = Path(__file__).resolve().parent.parent / "docs" / "images" / "step.svg"
SUFFIX = ": CPU a step"
COLOURS = ("#cbd5e1", "#2563eb")
"""Of before and after."""
LEAST = 0.01
"""Parts below this share of the step are added up as others, on both sides."""
OTHERS = "others"

Parts = dict[str, float]
"""Microseconds of processor time a step, by part."""


class InputError(Exception):
    """A file is not one of shares."""


def read(files: list[Path]) -> dict[str, Parts]:
    """Read one or two sides, the older first.

    Raises:
        InputError: Where a file has no shares, or there are not one or two sides.
    """
    sides: dict[str, Parts] = {}
    for file in files:
        try:
            found = json.loads(file.read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise InputError(f"{file}: {error}") from error
        if "rooms" in found:
            sides[file.stem] = found["rooms"]
        else:
            sides |= _of_entry_point(found, file)
    if not 1 <= len(sides) <= 2:
        raise InputError(f"expected one file with two commits, or two files; got {len(sides)}")
    return sides


def _of_entry_point(found: dict[str, Any], file: Path) -> dict[str, Parts]:
    of_shares = [one for one in found.get("benchmarks", ()) if one["name"] == "shares"]
    if not of_shares:
        raise InputError(
            f"{file}: it has no shares; python -m benchmarks shares --json writes them"
        )
    sides = {}
    for side, commit in (("old", found["against"]), ("new", found["commit"])):
        parts = {
            one["name"].removesuffix(SUFFIX): one[side]["median"]
            for one in of_shares[0]["figures"]
            if one["name"].endswith(SUFFIX) and one[side]
        }
        if parts:
            sides[commit] = parts
    return sides


def rows(sides: dict[str, Parts]) -> list[str]:
    """Return the parts that are drawn, the largest of the first side first, the others last."""
    first = next(iter(sides.values()))
    names = dict.fromkeys(name for parts in sides.values() for name in parts)
    large = [
        name
        for name in names
        if any(parts.get(name, 0) >= LEAST * sum(parts.values()) for parts in sides.values())
    ]
    return [*sorted(large, key=lambda name: -first.get(name, 0)), OTHERS]


def draw(sides: dict[str, Parts], picture: Path) -> None:
    """Draw a bar for each part and side."""
    names = rows(sides)
    thick = 0.8 / len(sides)
    with mpl.rc_context({"svg.fonttype": "none", "svg.hashsalt": "step", "font.size": 10}):
        figure, axes = plt.subplots(figsize=(8, 0.8 + 0.42 * len(names)), layout="constrained")
        for index, (side, parts) in enumerate(sides.items()):
            total = sum(parts.values())
            values = [parts.get(name, 0.0) for name in names[:-1]]
            values.append(total - sum(values))
            places = [row + (index - (len(sides) - 1) / 2) * thick for row in range(len(names))]
            colour = COLOURS[index + 2 - len(sides)]
            bars = axes.barh(places, values, thick, color=colour, label=f"{side}: {total:.0f} us")
            labels = [f"{value:.0f} us, {value / total:.0%}" for value in values]
            axes.bar_label(bars, labels, padding=3, fontsize=8)
        axes.set_yticks(range(len(names)), names)
        axes.invert_yaxis()
        axes.margins(x=0.14)
        axes.set_xlabel("processor time of a step of 50 ms, us")
        axes.spines[["top", "right"]].set_visible(False)
        axes.legend(loc="lower right", frameon=False)
        figure.savefig(picture, format="svg", metadata={"Date": None})
        plt.close(figure)


def main() -> int:
    """Draw the files of the command line; gives the exit code."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("files", type=Path, nargs="+", metavar="FILE")
    parser.add_argument("-o", "--output", type=Path, default=PICTURE, metavar="PICTURE")
    options = parser.parse_args()
    try:
        draw(read(options.files), options.output)
    except InputError as error:
        print(f"draw_shares.py: {error}", file=sys.stderr)
        return 2
    print(options.output)
    return 0


if __name__ == "__main__":
    sys.exit(main())
