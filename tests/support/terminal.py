"""What a terminal shows after it was sent some text."""

from __future__ import annotations

import re

CONTROL = re.compile(r"\x1b\[\??([0-9;]*)([A-Za-z])|([\r\n])|([^\x1b\r\n]+)")


def shown_by_terminal(sent: str) -> list[str]:
    """Return the rows of an endless terminal, without blanks at their ends and without colours.

    Raises:
        ValueError: For a control sequence that is not known here.
    """
    rows, row, column = [""], 0, 0
    for number, letter, control, text in CONTROL.findall(sent):
        match letter or control:
            case "":
                rows[row] = (
                    rows[row].ljust(column)[:column] + text + rows[row][column + len(text) :]
                )
                column += len(text)
            case "\r":
                column = 0
            case "\n":
                row, column = row + 1, 0  # as a terminal's driver does it
                rows += [""] * (row + 1 - len(rows))
            case "A":
                row = max(row - int(number), 0)
            case "K":
                rows[row] = ""
            case "m" | "h" | "l":
                pass
            case other:
                raise ValueError(f"not known: {other}")
    return [line.rstrip() for line in rows]
