"""What readers search for in the documentation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import yaml  # type: ignore[import-untyped]

from tests.support.project import ROOT

QUESTIONS: Mapping[str, Sequence[str]] = yaml.safe_load(
    (ROOT / "tests" / "docs" / "questions.yaml").read_text("utf-8")
)
"""What they type, and the pages of which one must be among the first three."""
