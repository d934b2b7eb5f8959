"""The search of the site finds the pages of `questions.yaml`, in a browser."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import quote

import pytest

from tests.support.browser import BROWSER, Page, browser
from tests.support.project import ROOT
from tests.support.questions import QUESTIONS
from tools import build_site

pytestmark = [
    pytest.mark.process,
    pytest.mark.skipif(BROWSER is None, reason="no Chromium is installed"),
]

IS_DONE = (
    "/finished|did not match/.test(document.querySelector('.search-summary')?.innerText)"
    " || document.querySelectorAll('#search-results li').length >= 3"
)
RESULTS = (
    "[...document.querySelectorAll('#search-results li > a')].slice(0, 3)"
    ".map((link) => new URL(link.href).pathname)"
)


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The site of this checkout, but for the page of the API, which takes long."""
    source = tmp_path_factory.mktemp("source")
    for name in ("README.md", "pyproject.toml"):
        shutil.copy(ROOT / name, source)
    shutil.copytree(ROOT / "docs", source / "docs")
    (source / "docs/reference/api.md").write_text("# Python API\n\nAll names.\n", encoding="utf-8")
    folder = tmp_path_factory.mktemp("site") / "x"
    build_site.build(source, folder, is_strict=False)
    return folder


@pytest.fixture(scope="module")
def chromium(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    """A browser."""
    with browser(tmp_path_factory.mktemp("profile")) as page:
        yield page


def test_the_right_page_is_among_the_first_three(site: Path, chromium: Page) -> None:
    """For every question, as for `bt-mission docs`."""
    search = (site / "search.html").as_uri()
    missed = {}
    for words, pages in QUESTIONS.items():
        chromium.visit(f"{search}?q={quote(words)}", width=1000, height=800)
        chromium.until(IS_DONE)
        results = [path.partition("/docs/")[2] for path in chromium.look(RESULTS)]
        if not {*results} & {f"{page}.html" for page in pages}:
            missed[words] = results
    assert missed == {}
