"""A search in the pages of the documentation, with the full-text index of SQLite (FTS5, BM25).

A page is ranked as a whole; of its sections, the best is shown. A word counts most in the title of
a page and in its line in the index, then in headings, then in the text, and least in examples.
"""

from __future__ import annotations

import re
import sqlite3
from collections.abc import Iterable, Iterator, Mapping, Sequence

from bt_mission.base.errors import BtMissionError
from bt_mission.views.manual import Page, PageSection, lines_of

_PAGES = "CREATE VIRTUAL TABLE pages USING fts5(title, about, headings, prose, code, {})"
_PAGE_RANK = "bm25(pages, 8, 8, 4, 1, 0.2)"
_SECTIONS = "CREATE VIRTUAL TABLE sections USING fts5(headings, about, prose, code, {})"
_SECTION_RANK = "bm25(sections, 10, 4, 1, 0.1)"
_WORDS = "tokenize='porter unicode61'"
"""Words are split at other characters than letters and digits; their endings do not count."""

UNIMPORTANT = frozenset(
    """
    a an and are as at be by can do does for from how i if in is it my no not of on or that the
    there this to was what when where which why will with
    """.split()  # noqa: SIM905 - as a list it would be thirty lines
)
"""Words of a question that its answer need not have."""


class PageIndex:
    """An index of pages, in memory.

    Args:
        pages: The pages.

    Raises:
        BtMissionError: SQLite has no FTS5 here.
    """

    def __init__(self, pages: Iterable[Page]) -> None:
        self._pages = list(pages)
        self._sections: list[PageSection] = []
        self._database = sqlite3.connect(":memory:")
        try:
            self._database.execute(_PAGES.format(_WORDS))
            self._database.execute(_SECTIONS.format(_WORDS))
        except sqlite3.DatabaseError as error:
            self.close()
            raise BtMissionError(
                f"the search needs SQLite with FTS5 ({error}); pages are shown without it",
                code="BT-905",
            ) from error
        for number, page in enumerate(self._pages):
            self._add(number, page)

    def close(self) -> None:
        """Forget everything."""
        self._database.close()

    def search(self, words: Sequence[str]) -> Sequence[PageSection]:
        """Return the best section of each page that has the words, the best page first.

        Pages with all words come before pages with some of them. If no page has any, a word may be
        the beginning of one.
        """
        wanted = _phrases(words)
        every, some = " AND ".join(wanted), " OR ".join(wanted)
        scores = [*self.scores(every), *self.scores(some)]
        if not scores:
            some = " OR ".join(f"{phrase}*" for phrase in wanted)
            scores = list(self.scores(some))
        return [self._best_section(name, some) for name in dict.fromkeys(scores)]

    def scores(self, expression: str) -> Mapping[str, float]:
        """Return the pages that match an expression of FTS5, by name, the best first.

        The score of several words joined by OR is the sum of their scores.
        """
        if not expression:
            return {}
        rows = self._database.execute(
            f"SELECT rowid, -{_PAGE_RANK} FROM pages WHERE pages MATCH ? "  # noqa: S608 - ours
            "ORDER BY 2 DESC, 1",
            (expression,),
        )
        return {self._pages[row].name: score for row, score in rows}

    def _best_section(self, page: str, expression: str) -> PageSection:
        rows = self._database.execute(
            "SELECT rowid FROM sections WHERE sections MATCH ? "  # noqa: S608 - ours
            f"ORDER BY {_SECTION_RANK}, rowid",
            (expression,),
        )
        sections: Iterator[PageSection] = (self._sections[row] for (row,) in rows)
        return next(section for section in sections if section.page == page)

    def _add(self, number: int, page: Page) -> None:
        listed = page.listed
        title = f"{listed.title} {listed.path}"
        texts: list[tuple[str, str]] = []
        for section in page.sections:
            lines = list(lines_of(section.text))
            prose = "".join(line for line, is_code in lines if not is_code)
            code = "".join(line for line, is_code in lines if is_code)
            texts.append((prose, code))
            is_first = not section.anchor
            headings = title if is_first else " ".join(section.titles[1:])
            about = listed.about if is_first else ""
            self._database.execute(
                "INSERT INTO sections(rowid, headings, about, prose, code) VALUES (?, ?, ?, ?, ?)",
                (len(self._sections), headings, about, prose, code),
            )
            self._sections.append(section)
        headings = " ".join(section.titles[-1] for section in page.sections)
        prose, code = map("".join, zip(*texts, strict=True))
        self._database.execute(
            "INSERT INTO pages(rowid, title, about, headings, prose, code) "
            "VALUES (?, ?, ?, ?, ?, ?)",
            (number, title, listed.about, headings, prose, code),
        )


def vocabulary(pages: Iterable[Page]) -> Sequence[str]:
    """Return the words of all headings."""
    headings = " ".join(section.titles[-1] for page in pages for section in page.sections)
    return sorted(set(re.findall(r"\w{3,}", headings.lower())))


def _phrases(words: Sequence[str]) -> Sequence[str]:
    """Return the words as FTS5 takes them; ``cancel_when`` is a phrase of two words."""
    given = [word for word in " ".join(words).split() if re.search(r"[^\W_]", word)]
    telling = [word for word in given if word.lower() not in UNIMPORTANT]
    return ['"{}"'.format(word.replace('"', " ")) for word in telling or given]
