"""The pages of the documentation lead to one another."""

import re

import pytest

from tests.support.project import ROOT

PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])
LINK = re.compile(r"\]\(([^)\s]+)\)")


def anchors(text: str) -> set[str]:
    """The anchors of a page's headings, as GitHub makes them."""
    titles = re.findall(r"^#+ (.+)$", text, re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_every_link_leads_somewhere(page):
    """Each relative link of a page names a file that is there, and a heading in it."""
    lost = []
    for target in LINK.findall(page.read_text(encoding="utf-8")):
        path, _, anchor = target.partition("#")
        if "://" in target:
            continue
        file = (page.parent / path).resolve() if path else page
        result = file.exists() and (
            not anchor or file.suffix != ".md" or anchor in anchors(file.read_text("utf-8"))
        )
        if not result:
            lost.append(target)
    assert lost == []


def test_every_page_is_reached():
    """docs/README.md lists every page of the documentation."""
    index = (ROOT / "docs" / "README.md").read_text(encoding="utf-8")
    linked = {(ROOT / "docs" / path.partition("#")[0]).resolve() for path in LINK.findall(index)}
    pages = {page for page in PAGES if page.is_relative_to(ROOT / "docs")}
    assert sorted(pages - linked - {ROOT / "docs" / "README.md"}) == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_every_page_says_first_what_it_is_for(page):
    """After its title a page opens with a paragraph, not with a heading, a list or code."""
    title, _, rest = page.read_text(encoding="utf-8").lstrip().partition("\n")
    assert title.startswith("# ")
    assert re.match(r"[A-Za-z`*\[]", rest.strip()), rest.strip()[:60]
