"""What readers search for in the documentation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import yaml  # type: ignore[import-untyped]

from tests.support.project import ROOT

FILES = (
    ROOT / "tests" / "docs" / "questions.yaml",
    *sorted((ROOT / "tests" / "commands").glob("*/questions.yaml")),
)
QUESTIONS: Mapping[str, Sequence[str]] = {
    words: pages
    for file in FILES
    for words, pages in yaml.safe_load(file.read_text("utf-8")).items()
}
"""What they type, and the pages of which one must be among the first three."""
