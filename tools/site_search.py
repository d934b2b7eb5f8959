"""The ranking of the site's search: that of `bt-mission docs`.

Sphinx finds the pages that have all words, and scores them by whether a word is in a title. Its
place for another score takes the file that is made here: the weight of each word in each page.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping

from bt_mission.views import page_search
from bt_mission.views.manual import Manual
from bt_mission.views.page_search import UNIMPORTANT, PageIndex


def split(text: str) -> list[str]:
    """Return the words of a text; a name of several words, such as ``cancel_when``, and each."""
    names = re.findall(r"\w+", text)
    return [*names, *(word for name in names if "_" in name for word in name.split("_") if word)]


def weights(manual: Manual, stem: Callable[[str], str]) -> Mapping[str, Mapping[int, float]]:
    """Return the weights of words in pages: by the stem of a word and the number of a page."""
    pages = [manual.page(name) for name in manual.names]
    numbers = {page.name: number for number, page in enumerate(pages)}
    texts = [text for page in pages for text in (page.listed.title, page.listed.about)]
    texts += [section.text for page in pages for section in page.sections]
    words = sorted({*split(" ".join(texts).lower())} - UNIMPORTANT, key=len, reverse=True)
    index = PageIndex(pages)
    return {
        # Words of one stem have one score; the shortest is taken.
        root: {
            numbers[name]: float(f"{score:.3g}")  # tiny if most pages have the word
            for name, score in _scores(index, word).items()
        }
        for root, word in {stem(word): word for word in words}.items()
    }


def _scores(index: PageIndex, word: str) -> Mapping[str, float]:
    """Return the weights of a word; of a name such as ``cancel_when``, the least of its words."""
    scores = [index.scores(page_search.stem(part)) for part in word.split("_") if part]
    pages = set.intersection(*(set(score) for score in scores)) if scores else set()
    return {page: min(score[page] for score in scores) for page in pages}


def data(manual: Manual, stem: Callable[[str], str]) -> str:
    """Return what the scorer of the site takes, as JavaScript."""
    pages = [f"docs/{page.path}" for page in manual.names.values()]
    compact = json.dumps(weights(manual, stem), separators=(",", ":"))
    return f"const PAGES = {json.dumps(pages)};\nconst WEIGHTS = {compact};\n"
