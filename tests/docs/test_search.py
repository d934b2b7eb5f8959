"""A search finds the page that a reader looks for: the questions of `questions.yaml`."""

from __future__ import annotations

import pytest

from bt_mission.views.manual import Manual
from bt_mission.views.page_search import PageIndex
from tests.support.project import ROOT
from tests.support.questions import QUESTIONS
from tests.support.thorough import sample


@pytest.fixture(scope="module")
def manual() -> Manual:
    """The pages of this checkout."""
    return Manual(ROOT / "docs")


@pytest.fixture(scope="module")
def index(manual: Manual) -> PageIndex:
    """All of them."""
    return PageIndex(map(manual.page, manual.names))


@pytest.mark.parametrize("words", sample(QUESTIONS, 3))
def test_the_right_page_is_among_the_first_three(
    manual: Manual, index: PageIndex, words: str
) -> None:
    """Of `bt-mission docs WORDS`."""
    results = [manual.names[section.page].path for section in index.search(words.split())]
    assert {*results[:3]} & {*QUESTIONS[words]}, results[:10]


def test_a_page_of_each_question_exists(manual: Manual) -> None:
    """By its path."""
    paths = {page.path for page in manual.names.values()}
    assert [words for words, pages in QUESTIONS.items() if paths.isdisjoint(pages)] == []
