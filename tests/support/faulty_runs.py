"""How the leaves of missions end in which something is broken."""

from __future__ import annotations

from typing import Any


def outcome(run: Any, leaf: str = "turn") -> tuple[float, str]:
    """Run until a leaf has ended; return when that was, and how."""
    run.until(lambda s: s.leaf(leaf).failed or s.leaf(leaf).succeeded)
    result = run.leaf(leaf)
    return result.since, result.outcome or result.status
