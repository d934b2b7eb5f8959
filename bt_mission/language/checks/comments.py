"""Texts of a mission that a comment cuts short, though its author may not have meant one."""

from __future__ import annotations

import re
from collections.abc import Iterator

from bt_mission.core.diagnostics import Diagnostic, fault_at, quoted
from bt_mission.core.yaml.document import Document
from bt_mission.language.nodes.base import NodeModel
from bt_mission.language.nodes.leaves import LogNode

_LOOKS_LIKE_TEXT = re.compile(r" #[^\s#!]")
"""A comment whose first word has no blank before it: `#1`, rather than `# the first`."""


def cut_texts(document: Document, tree: NodeModel) -> Iterator[Diagnostic]:
    """Yield a warning for every name and log message that a comment ends which looks like text."""
    for node in tree.walk():
        if node.name:
            yield from _cut(document, node, "name", node.name)
        if isinstance(node, LogNode):
            yield from _cut(document, node, "log", node.message.text)


def _cut(document: Document, node: NodeModel, key: str, text: str) -> Iterator[Diagnostic]:
    path = (*node.path, key)
    line, column = document.position(path)
    source = document.lines[line - 1] if 0 < line <= len(document.lines) else ""
    start = column - 1
    if not source.startswith(text, start):  # in quotes, on several lines, or of another file
        return
    after = source[start + len(text) :]
    if _LOOKS_LIKE_TEXT.match(after):
        message = f"'#' begins a comment, so all that is left is {quoted(text)}"
        hint = "put the text in quotes"
        at = line, column + len(text) + 1
        yield fault_at(at, document.file, document.lines, message, hint, "warning")
