"""The pages of the documentation, as they lie in a checkout or in an installed wheel."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

from bt_mission.base.commands import ROWS, all_rows
from bt_mission.base.errors import BtMissionError
from bt_mission.base.files import docs_folder

INDEX = "README.md"
"""The page that lists all others; the navigation of the site follows it, too."""

OTHERS = "Commands of other packages"
"""The heading of the pages that these bring."""

LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^)\s]*)\)")
"""A picture or a link: its mark, its text, its target."""
_ROW = re.compile(r"^\| \[([^\]]+)\]\((\S+)\.md\) \| (.*) \|$", re.MULTILINE)
_FENCE = re.compile(r" {0,3}(```+|~~~+)")
_HEADING = re.compile(r"(#{1,6}) +(.*?)[ #]*$")


@dataclass(frozen=True)
class Listed:
    """A page as the index lists it.

    Attributes:
        path: In the folder of the pages, without its suffix: ``how-to/fleet``.
        title: As the index calls it.
        about: What it is about, in one line.
    """

    path: str
    title: str
    about: str


@dataclass(frozen=True)
class PageSection:
    """A heading of a page, with the text up to the next heading.

    Attributes:
        page: The name of its page.
        titles: The headings above it, from the page's title on, and its own.
        anchor: Its name in links; empty for the page's title.
        text: Its Markdown, with the heading.
    """

    page: str
    titles: Sequence[str]
    anchor: str
    text: str

    @property
    def address(self) -> str:
        """Its name on the command line: ``fleet#on-a-real-graph``."""
        return f"{self.page}#{self.anchor}" if self.anchor else self.page


@dataclass(frozen=True)
class Page:
    """A page.

    Attributes:
        name: What commands call it: the name of its file, with the folder if two files share it.
        listed: Its line in the index.
        sections: In their order.
    """

    name: str
    listed: Listed
    sections: Sequence[PageSection]

    def part(self, anchor: str) -> Sequence[PageSection]:
        """Return the section with this anchor and those below it; without it, nothing."""
        anchors = [section.anchor for section in self.sections]
        if anchor not in anchors:
            return []
        first, *rest = self.sections[anchors.index(anchor) :]
        depth = len(first.titles)
        end = next((n for n, other in enumerate(rest) if len(other.titles) <= depth), None)
        return [first, *rest[:end]]


class Manual:
    """All pages that the index lists.

    Args:
        folder: The folder of the index.
        others: Pages that it does not list: their files, without the suffix, each with what the
            list says about it.

    Attributes:
        groups: The pages of each section of the index.
        names: The pages by their names, in the order of the index.

    Raises:
        BtMissionError: When the index cannot be read.
    """

    def __init__(self, folder: Path, others: Mapping[Path, str] | None = None) -> None:
        self._folder = folder
        self.groups = dict(index_of(self._read(INDEX)))
        if others:
            self.groups[OTHERS] = [
                Listed(str(path), path.name, about) for path, about in others.items()
            ]
        listed = [page for group in self.groups.values() for page in group]
        stems = [Path(page.path).name for page in listed]
        self.names: Mapping[str, Listed] = {
            stem if stems.count(stem) == 1 else page.path: page
            for stem, page in zip(stems, listed, strict=True)
        }

    def page(self, name: str) -> Page:
        """Read a page, by its name.

        Raises:
            BtMissionError: When it cannot be read.
        """
        listed = self.names[name]
        return Page(name, listed, list(_sections(name, self._read(f"{listed.path}.md"))))

    def name_of(self, word: str) -> str | None:
        """Return the name of the page with this name or path, with or without ``.md``."""
        wanted = word.removeprefix("docs/").removesuffix(".md")
        return next(
            (name for name, page in self.names.items() if wanted in (name, page.path)), None
        )

    def _read(self, name: str) -> str:
        try:
            return (self._folder / name).read_text(encoding="utf-8")
        except OSError as error:
            reason = error.strerror or error
            raise BtMissionError(
                f"cannot read {self._folder / name}: {reason}", code="BT-101"
            ) from error


def manual() -> Manual:
    """Return the pages that are installed with bt-mission.

    Raises:
        BtMissionError: When they are not there.
    """
    folder = docs_folder()
    if folder is None:
        raise BtMissionError("no pages found: is the installation complete?", code="BT-101")
    return Manual(folder, dict(_pages_of_others()))


def _pages_of_others() -> Iterator[tuple[Path, str]]:
    """Yield the pages in the packages of other people's commands, with what they are about."""
    for row in all_rows().values():
        if row in ROWS:
            continue
        folder = Path(str(files(row.folder)))
        for page in row.pages:
            if (folder / f"{page}.md").is_file():
                yield folder / page, row.help


def index_of(text: str) -> Mapping[str, Sequence[Listed]]:
    """Return the pages that the text of an index lists, by the headings of its sections."""
    sections = re.split(r"^## ", text, flags=re.MULTILINE)[1:]
    return {
        section.partition("\n")[0]: [
            Listed(path, title, plain(about)) for title, path, about in _ROW.findall(section)
        ]
        for section in sections
    }


def plain(markdown: str) -> str:
    """Return a line of Markdown without the marks of links and code."""
    return LINK.sub(r"\2", markdown).replace("`", "")


def lines_of(markdown: str) -> Iterator[tuple[str, bool]]:
    """Yield each line, with its end, and whether it belongs to a block of code."""
    fence = ""
    for line in markdown.splitlines(keepends=True):
        mark = _FENCE.match(line)
        yield line, bool(fence or mark)
        if mark and not fence:
            fence = mark[1]
        elif mark and line.strip() == mark[1] and mark[1].startswith(fence):
            fence = ""


def _sections(page: str, text: str) -> Iterator[PageSection]:
    """Split the text of a page at its headings."""
    titles: list[str] = []
    anchors: list[str] = []
    lines: list[str] = []
    for line, is_code in lines_of(text):
        heading = None if is_code else _HEADING.match(line.rstrip())
        if heading:
            if titles:
                yield PageSection(page, tuple(titles), anchors[-1], "".join(lines))
            titles[len(heading[1]) - 1 :] = [plain(heading[2])]
            anchors.append(_anchor(titles[-1], anchors) if len(titles) > 1 else "")
            lines = []
        lines.append(line)
    yield PageSection(page, tuple(titles), anchors[-1], "".join(lines))


def _anchor(title: str, taken: Sequence[str]) -> str:
    """Return the anchor of a heading as GitHub and the site make it."""
    anchor = re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-")
    same = sum(re.fullmatch(rf"{re.escape(anchor)}(-\d+)?", other) is not None for other in taken)
    return f"{anchor}-{same}" if same else anchor


def page_names(_: list[str]) -> list[str]:
    """Return the names of all pages, for the completion of shells."""
    return list(manual().names)
