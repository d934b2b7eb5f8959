"""Draw the packages and their imports: docs/images/layers.svg.

A line is an import that no longer path of imports implies. tools/make_generated.py writes the file.
"""

from __future__ import annotations

from collections.abc import Iterable
from html import escape

from tools.check_layers import LAYERS, PARTS, all_imports, is_in

WIDTH, ROW, TOP, BOX, GAP = 1230, 62, 44, (116, 30), 12
LEFT = {"bt_mission": 110, "action_servers": 540, "sim": 880}
COLOURS = {"bt_mission": "#dbeafe", "action_servers": "#dcfce7", "sim": "#fef3c7"}


ROW_SCALE = {"action_servers": (0.9, 1), "sim": (0.62, 0.6)}
"""Rows of a column as a share of those of bt_mission, and the lowest: all imports point down."""


def packages() -> dict[str, tuple[str, float]]:
    """Return each package that is drawn, with its top-level folder and its row from below."""
    heights = {
        name: ("bt_mission", float(row)) for row, layer in enumerate(LAYERS) for name in layer
    }
    for top, (scale, lowest) in ROW_SCALE.items():
        for row, parts in enumerate(PARTS[top]):
            heights |= {f"{top}.{part}": (top, lowest + row * scale) for part in parts}
    return heights


def _box(module: str, known: Iterable[str]) -> str:
    """Return the innermost box of a module, or nothing."""
    return max((name for name in known if is_in(module, name)), key=len, default="")


def edges(known: dict[str, tuple[str, float]]) -> set[tuple[str, str]]:
    """Return who imports whom, without what follows from the others."""
    direct = set()
    for edge in all_imports():
        pair = [_box(module, known) for module in (edge.importer, edge.imported)]
        if all(pair) and pair[0] != pair[1]:
            direct.add((pair[0], pair[1]))
    ordered = sorted(direct)
    below: dict[str, set[str]] = {}

    def reach(name: str) -> set[str]:
        if name not in below:
            below[name] = set()
            for importer, imported in ordered:
                if importer == name:
                    below[name] |= {imported} | reach(imported)
        return below[name]

    return {
        (a, b)
        for a, b in ordered
        if not any(b in reach(c) for x, c in ordered if x == a and c != b)
    }


def draw() -> str:
    """Return the picture as SVG."""
    known = packages()
    rows = len(LAYERS)
    height = TOP + rows * ROW + 10
    centre: dict[str, tuple[float, float]] = {}
    for top, left in LEFT.items():
        for row in sorted({row for _, row in known.values()}):
            here = [name for name, place in known.items() if place == (top, row)]
            for index, name in enumerate(here):
                x = left + (index - (len(here) - 1) / 2) * (BOX[0] + GAP)
                centre[name] = (x, height - 10 - (row + 0.5) * ROW)
    shift = BOX[0] / 2 + 8 - min(x for x, _ in centre.values())
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}">',
        '<g font-family="sans-serif" font-size="12">',
        "<title>Packages by layer; a line is an import, downwards</title>",
        f'<rect width="{WIDTH}" height="{height}" fill="white"/>',
    ]
    for top, left in LEFT.items():
        lines.append(
            f'<text x="{left + shift:.0f}" y="24" text-anchor="middle" font-size="15"'
            f' font-weight="bold">{top}</text>'
        )
    for a, b in sorted(edges(known)):
        (x1, y1), (x2, y2) = centre[a], centre[b]
        y1, y2 = y1 + BOX[1] / 2, y2 - BOX[1] / 2
        bend = (y1 + y2) / 2
        lines.append(
            f'<path d="M{x1 + shift:.0f} {y1:.0f} C{x1 + shift:.0f} {bend:.0f}'
            f' {x2 + shift:.0f} {bend:.0f} {x2 + shift:.0f} {y2:.0f}"'
            ' fill="none" stroke="#64748b" stroke-opacity="0.7"/>'
        )
    for name, (x, y) in centre.items():
        top = name.partition(".")[0]
        lines += [
            f'<g transform="translate({x + shift:.0f} {y:.0f})">',
            f'<rect x="{-BOX[0] / 2:g}" y="{-BOX[1] / 2:g}" width="{BOX[0]}" height="{BOX[1]}"',
            f'  rx="5" fill="{COLOURS[top]}" stroke="#334155"/>',
            f'<text y="4" text-anchor="middle">{escape(name.partition(".")[2])}</text></g>',
        ]
    return "\n".join([*lines, "</g>", "</svg>"]) + "\n"
