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
LANGUAGE_PAGES = "\n".join(
    (ROOT / "docs" / "reference" / f"{name}.md").read_text(encoding="utf-8")
    for name in (
        *("mission-language", "nodes", "actions", "modifiers"),
        *("variables", "subtrees", "python", "expressions"),
    )
)
"""The text of the pages of the mission language."""
