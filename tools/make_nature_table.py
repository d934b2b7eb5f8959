#!/usr/bin/env python3
"""Write the table of nature's quantities in docs/reference/nature.md, from their declaration.

A test compares the page with the result; `make generated` writes it.
"""

from __future__ import annotations

import sys
from pathlib import Path

from bt_mission.core.nature import QUANTITIES, Quantity

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "reference" / "nature.md"
BEGIN, END = "<!-- the quantities: tools/make_nature_table.py -->", "<!-- end of the quantities -->"


def table() -> str:
    """Return the table."""
    head = "| quantity | unit | mild | usual | harsh | drawn | what it is | source |"
    return "\n".join([head, "|---" * 8 + "|", *map(_line, QUANTITIES)])


def _line(one: Quantity) -> str:
    values = " | ".join(f"{value:g}" for value in (one.mild, one.usual, one.harsh))
    cells = (f"`{one.name}`", one.unit, values, one.shape, one.text, one.source)
    return f"| {' | '.join(cells)} |"


def with_table(page: str) -> str:
    """Return a page with the present table."""
    before, _, rest = page.partition(BEGIN)
    _, _, after = rest.partition(END)
    return f"{before}{BEGIN}\n\n{table()}\n\n{END}{after}"


def main() -> int:
    """Write the page."""
    PAGE.write_text(with_table(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
    print(PAGE)
    return 0


if __name__ == "__main__":
    sys.exit(main())
