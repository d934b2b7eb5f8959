#!/usr/bin/env python3
"""Write the table of faults in docs/reference/scenarios.md, from the faults themselves.

A test compares the page with what this gives; `make generated` writes it.
"""

from __future__ import annotations

import sys
from pathlib import Path

from bt_mission.faults import FAULTS, Faults
from bt_mission.faults.table import FaultKind

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "reference" / "scenarios.md"
BEGIN, END = "<!-- the table of faults: tools/make_fault_table.py -->", "<!-- end of the table -->"


def table() -> str:
    """Return a table for each area of faults."""
    lines = []
    for area in Faults.__mro__:
        kinds = [FAULTS[name] for name in vars(area) if name in FAULTS]
        if kinds:
            title = (area.__doc__ or "").partition(".")[0]
            lines += ["", f"**{title}**", "", "| fault | what happens |", "|---|---|"]
            lines += [f"| {_code(one.usage)} | {_told(one)} |" for one in kinds]
    return "\n".join(lines)


def _code(usage: str) -> str:
    return f"`{usage}`".replace("|", "\\|")


def _told(kind: FaultKind) -> str:
    arguments = [
        f"`{one.name}`: {one.text[:1].lower()}{one.text[1:]}"
        for one in kind.parameters.values()
        if one.text
    ]
    return " ".join([kind.text, *arguments]).replace("``", "`").replace("|", "\\|")


def with_table(page: str) -> str:
    """Return a page with the table as it is now."""
    before, _, rest = page.partition(BEGIN)
    _, _, after = rest.partition(END)
    return f"{before}{BEGIN}\n{table()}\n\n{END}{after}"


def main() -> int:
    """Write the page."""
    PAGE.write_text(with_table(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
    print(PAGE)
    return 0


if __name__ == "__main__":
    sys.exit(main())
