"""A search in the pages of the documentation, by words in titles and text.

A page is ranked as a whole; of its sections, the best is shown. A word counts most in the title of
a page and in its line in the index, then in headings, then in the text, and least in examples. It
counts more if fewer pages have it.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from bt_mission.views.manual import Page, PageSection, lines_of

WEIGHTS = (16.0, 6.0, 1.0, 0.2)
"""Of a word in the title, in headings, in prose and in examples."""
ENOUGH = 2.0
"""So often a word has half of the weight of one that is in every line."""

UNIMPORTANT = frozenset(
    """
    a an and are as at be by can do does for from how i if in is it my no not of on or that the
    there this to was what when where which why will with
    """.split()  # noqa: SIM905 - as a list it would be thirty lines
)
"""Words of a question that its answer need not have."""

_ENDINGS = re.compile(r"(?<=\w{3})(ations?|ings?|ed|es|e|s)$")

Words = Counter[str]


@dataclass(frozen=True)
class _SearchedText:
    """What is searched of a page or a section: the words of its parts, as in :data:`WEIGHTS`."""

    parts: tuple[Words, Words, Words, Words]

    def score(self, word: str) -> float:
        """Return the weight of a word here; 0 without it."""
        return sum(
            weight * words[word] / (words[word] + ENOUGH * math.log(2 + words.total()))
            for weight, words in zip(WEIGHTS, self.parts, strict=True)
            if words[word]
        )


class PageIndex:
    """The words of pages.

    Args:
        pages: The pages.
    """

    def __init__(self, pages: Iterable[Page]) -> None:
        self._pages: dict[str, _SearchedText] = {}
        self._sections: dict[str, list[tuple[PageSection, _SearchedText]]] = {}
        for page in pages:
            title = _words(f"{page.listed.title} {page.listed.path} {page.listed.about}")
            entries = [_of_section(section, title) for section in page.sections]
            headings, prose, code = (
                sum((entry.parts[at] for entry in entries), Counter()) for at in (1, 2, 3)
            )
            self._pages[page.name] = _SearchedText((title, headings, prose, code))
            self._sections[page.name] = list(zip(page.sections, entries, strict=True))

    def search(self, words: Sequence[str]) -> Sequence[PageSection]:
        """Return the best section of each page that has the words, the best page first.

        Pages with all words come before pages with some of them. If no page has any, a word may be
        the beginning of one.
        """
        given = re.findall(r"[^\W_]+", " ".join(words).lower())
        wanted = [stem(word) for word in given if word not in UNIMPORTANT] or given
        known = {word for entry in self._pages.values() for part in entry.parts for word in part}
        if not known.intersection(wanted):
            wanted = [word for word in known if any(map(word.startswith, wanted))]
        scores = [self.scores(word) for word in dict.fromkeys(wanted)]
        weights = {name: [score.get(name, 0.0) for score in scores] for name in self._pages}
        ranked = sorted(
            weights, key=lambda name: (all(weights[name]), sum(weights[name])), reverse=True
        )
        return [self._best_section(name, wanted) for name in ranked if any(weights[name])]

    def scores(self, word: str) -> Mapping[str, float]:
        """Return the weight of a stem in each page that has it, by the page's name."""
        having = {
            name: score for name, entry in self._pages.items() if (score := entry.score(word))
        }
        rarity = math.log((1 + len(self._pages)) / (0.5 + len(having)))
        return {name: score * max(rarity, 0.01) for name, score in having.items()}

    def _best_section(self, page: str, words: Sequence[str]) -> PageSection:
        sections = self._sections[page]
        return max(sections, key=lambda section: sum(map(section[1].score, words)))[0]


def _of_section(section: PageSection, title: Words) -> _SearchedText:
    lines = list(lines_of(section.text))
    prose = "".join(line for line, is_code in lines if not is_code)
    code = "".join(line for line, is_code in lines if is_code)
    own = Counter[str]() if section.anchor else title
    return _SearchedText((own, _words(section.titles[-1]), _words(prose), _words(code)))


def stem(word: str) -> str:
    """Return a word without its ending."""
    return _ENDINGS.sub("", word.lower())


def _words(text: str) -> Words:
    return Counter(map(stem, re.findall(r"[^\W_]+", text)))


def vocabulary(pages: Iterable[Page]) -> Sequence[str]:
    """Return the words of all headings."""
    headings = " ".join(section.titles[-1] for page in pages for section in page.sections)
    return sorted(set(re.findall(r"\w{3,}", headings.lower())))
