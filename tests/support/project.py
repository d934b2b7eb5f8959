"""Where the project's own files are."""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

MISSIONS = sorted(
    path
    for path in (ROOT / "missions").rglob("*.yaml")
    if not path.stem.endswith((".scenario", ".fleet"))
)
"""Every shipped mission; the scenarios stand beside them."""
SCENARIOS = sorted((ROOT / "missions").rglob("*.scenario.yaml"))
