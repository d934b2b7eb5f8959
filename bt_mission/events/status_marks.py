"""How a status looks; readable without colour, and without UTF-8."""

from __future__ import annotations

from py_trees.common import Status

UNICODE = {
    Status.SUCCESS: "✓",
    Status.FAILURE: "✗",
    Status.RUNNING: "▶",
    Status.INVALID: "·",
}
ASCII = {
    Status.SUCCESS: "+",
    Status.FAILURE: "x",
    Status.RUNNING: ">",
    Status.INVALID: "-",
}
STYLES = {
    Status.SUCCESS: "green",
    Status.FAILURE: "red",
    Status.RUNNING: "bold cyan",
    Status.INVALID: "dim",
}


def glyphs_for(encoding: str | None) -> dict[Status, str]:
    """The glyphs that a stream of this encoding can show."""
    try:
        "".join(UNICODE.values()).encode(encoding or "ascii")
    except (UnicodeEncodeError, LookupError):
        return ASCII
    return UNICODE
