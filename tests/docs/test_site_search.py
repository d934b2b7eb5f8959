"""The site of this checkout is built, and its search finds the pages of `questions.yaml`."""

from __future__ import annotations

from pathlib import Path
from urllib.parse import quote

import pytest

from tests.support.browser import BROWSER
from tests.support.project import ROOT
from tests.support.questions import QUESTIONS
from tests.support.report_pages import text_of
from tools import build_site

pytestmark = pytest.mark.process

IS_DONE = (
    "/finished|did not match/.test(document.querySelector('.search-summary')?.innerText)"
    " || document.querySelectorAll('#search-results li').length >= 3"
)
RESULTS = (
    "[...document.querySelectorAll('#search-results li > a')].slice(0, 3)"
    ".map((link) => new URL(link.href).pathname)"
)


@pytest.mark.thorough
def test_pages_are_built_and_found(tmp_path: Path, request: pytest.FixtureRequest) -> None:
    """Without a warning; the right page is among the first three for every question."""
    site = tmp_path / "x"
    build_site.build(ROOT, site, is_strict=True)
    pages = {page.relative_to(ROOT).with_suffix(".html") for page in (ROOT / "docs").rglob("*.md")}
    assert [page for page in pages if not (site / page).is_file()] == []
    assert "run_fleet" in (site / "docs/reference/api.html").read_text(encoding="utf-8")
    commands = text_of(site / "docs/reference/commands.html")
    assert "usage: bt-mission run [-h]" in commands
    assert "usage: bt-mission missions copy [-h]" in commands
    assert "with --web: listen on this port" in commands
    if BROWSER is None:
        pytest.skip("no Chromium is installed")
    chromium = request.getfixturevalue("chromium")
    missed = {}
    for words, names in QUESTIONS.items():
        address = f"{(site / 'search.html').as_uri()}?q={quote(words)}"
        chromium.visit(address, width=1000, height=800)
        chromium.until(IS_DONE)
        results = [path.partition("/docs/")[2] for path in chromium.look(RESULTS)]
        if not {*results} & {f"{name}.html" for name in names}:
            missed[words] = results
    assert missed == {}
