"""``bt-mission docs``: the pages of the documentation, in the terminal and without a network."""

from __future__ import annotations

import argparse
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import PurePosixPath
from posixpath import dirname, join, normpath

from bt_mission.base.text import columns, cut
from bt_mission.cli.exits import NOTHING_FOUND, SUCCESS
from bt_mission.cli.parser import Command, Option
from bt_mission.views.manual import LINK, Manual, PageSection, lines_of, manual
from bt_mission.views.terminal.streams import unescaped

MOST_OTHERS = 5
"""Pages that are named below the best one."""
MOST_COLUMNS = 120
"""Of a line of text on a terminal."""

EPILOG = """\
examples:
  bt-mission docs                      list all pages
  bt-mission docs timeout              search: the best section, and links to others
  bt-mission docs two robots
  bt-mission docs fleet                a page, by its name
  bt-mission docs modifiers#outputs    a section of a page
  bt-mission docs files > files.md     a page as Markdown

On a terminal the text is formatted, and long text is shown with $PAGER (default: less). In a pipe
it is Markdown. NO_COLOR=1 turns colours off.

exit codes: 0 success, 1 nothing found
"""


def docs(options: argparse.Namespace) -> int:
    """Print the list of pages, a page, a section, or what a search finds."""
    pages = manual()
    words: Sequence[str] = options.topic
    if not words:
        _print_list(pages)
        return SUCCESS
    name, _, anchor = words[0].partition("#")
    named = pages.name_of(name) if len(words) == 1 else None
    if named is None:
        return _search(pages, words)
    part = pages.page(named).part(anchor)
    if not part:
        return _refuse_anchor(pages, named, anchor)
    _show(pages, part, [])
    return SUCCESS


def _print_list(pages: Manual) -> None:
    names = {page.path: name for name, page in pages.names.items()}
    width = shutil.get_terminal_size().columns if sys.stdout.isatty() else None
    rows = columns((names[page.path], page.about) for page in pages.names.values())
    lines = iter(rows)
    for group, listed in pages.groups.items():
        print(group)
        for _, line in zip(listed, lines, strict=False):
            print(f"  {line}" if width is None else cut(f"  {line}", width))
        print()
    print("bt-mission docs PAGE shows a page, bt-mission docs WORDS searches")


def _search(pages: Manual, words: Sequence[str]) -> int:
    from bt_mission.base.diagnostics import did_you_mean
    from bt_mission.views.page_search import PageIndex, vocabulary

    read = [pages.page(name) for name in pages.names]
    hits = PageIndex(read).search(words)
    if not hits:
        known = [*pages.names, *vocabulary(read)]
        hint = next(filter(None, (did_you_mean(word.lower(), known) for word in words)), None)
        reason = f"no page has {' '.join(words)!r}{f'; {hint}' if hint else ''}"
        print(f"{reason} (bt-mission docs lists all pages)", file=sys.stderr)
        return NOTHING_FOUND
    # Two pages share the name: both come first.
    best, *others = sorted(hits, key=lambda part: PurePosixPath(part.page).name != words[0])
    part = next(page for page in read if page.name == best.page).part(best.anchor)
    _show(pages, part, [best, *others[:MOST_OTHERS]])
    return SUCCESS


def _refuse_anchor(pages: Manual, name: str, anchor: str) -> int:
    from bt_mission.base.diagnostics import did_you_mean, listed

    anchors = [section.anchor for section in pages.page(name).sections if section.anchor]
    hint = did_you_mean(anchor, anchors) or f"sections: {listed(anchors)}"
    print(f"the page {name} has no section {anchor!r}; {hint}", file=sys.stderr)
    return NOTHING_FOUND


def _show(pages: Manual, part: Sequence[PageSection], hits: Sequence[PageSection]) -> None:
    """Print a part of a page, and below it what a search has found: this part first."""
    markdown = "".join(section.text for section in part)
    below = list(_below(hits))
    if not sys.stdout.isatty():
        print(markdown.rstrip("\n"))
        print("\n".join(below), end="\n" if below else "")
        return
    from rich.markdown import Markdown
    from rich.theme import Theme

    from bt_mission.views.terminal.console import EscapingConsole

    console = EscapingConsole(sys.stdout, theme=Theme({"markdown.code": "bold"}))
    width = min(console.width, MOST_COLUMNS)
    with console.capture() as captured:
        text = _for_terminal(markdown, pages, pages.names[part[0].page].path)
        shown = Markdown(text, code_theme="ansi_dark", hyperlinks=False)
        console.print(shown, width=width)
        for line in below:
            console.print(line, no_wrap=True, overflow="ellipsis")
    output = captured.get()
    is_long = output.count("\n") >= console.height
    if not (is_long and not console.is_dumb_terminal and _page(output)):
        unescaped(sys.stdout).write(output)


def _below(hits: Sequence[PageSection]) -> Iterator[str]:
    """Yield the commands that show what a search has found."""
    if hits:
        yield ""
        yield "Also found in:"
        rows = [(f"bt-mission docs {each.address}", " > ".join(each.titles)) for each in hits]
        yield from (f"  {line}" for line in columns(rows))


def _for_terminal(markdown: str, pages: Manual, path: str) -> str:
    """Return a text of the page at this path without pictures, its links named as pages are."""
    names = {page.path: name for name, page in pages.names.items()}

    def as_text(link: re.Match[str]) -> str:
        mark, text, target = link.groups()
        if mark:
            return f"*Picture: {text}*"
        if "://" in target:
            return link[0]
        file, _, anchor = target.partition("#")
        beside = normpath(join(dirname(path), file)).removesuffix(".md") if file else path
        if beside not in names:
            return text
        address = names[beside] + (f"#{anchor}" if anchor else "")
        return text if address == text.lower() else f"{text} (`{address}`)"

    return "".join(
        line if is_code else LINK.sub(as_text, line) for line, is_code in lines_of(markdown)
    )


def _page(text: str) -> bool:
    """Show a text with the pager; false where there is none."""
    command = shlex.split(os.environ.get("PAGER") or "less")
    if not command or shutil.which(command[0]) is None:
        return False
    # Ctrl-C is for the pager. A handler, unlike SIG_IGN, is not inherited by it.
    before = signal.signal(signal.SIGINT, lambda *_: None)
    pager = subprocess.Popen(  # noqa: S603 - the pager of the user
        command, stdin=subprocess.PIPE, text=True, env={"LESS": "FRX", **os.environ}
    )
    pager.communicate(text)
    signal.signal(signal.SIGINT, before)
    return True


COMMANDS = {
    "docs": Command(
        docs,
        "Shows a page of the documentation, which is installed with bt-mission, or searches all "
        "pages.",
        (
            Option(
                "topic",
                "name of a page, or words to search for (default: list all pages)",
                nargs="*",
                completes="pages",
            ),
        ),
        EPILOG,
    )
}
