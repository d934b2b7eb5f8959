"""Places in Python code where a small change makes a defect, as text: the rest of the file stays.

Docstrings, annotations, texts, logs, caches and code that only type checkers read have no places.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

FLIPPED = {"<=": "<", ">=": ">", "==": "!=", "!=": "==", "<": "<=", ">": ">="}
LOGGED = {
    "debug",
    "info",
    "warn",
    "warning",
    "error",
    "exception",
    "fatal",
    "log",
    "print",
    "super",
}
NOT_SWAPPED = {"cast", "getattr", "hasattr", "isclose", "isinstance", "issubclass", "max", "min"}
TEXT_ONLY = {"__format__", "__hash__", "__repr__", "__str__"}
TEXTS = {"hint", "message", "reason", "said", "text"}
NOT_RUN = {"annotation", "bases", "decorator_list", "returns"}


@dataclass(frozen=True)
class Place:
    """A place in a file, and the change that makes it a defect."""

    kind: str
    file: str
    function: str
    before: str
    after: str
    ordinal: int  # among the places of this kind in this function
    line: int
    start: int
    end: int
    text: str

    def planted(self, source: bytes) -> bytes:
        """Return the source with the defect."""
        return source[: self.start] + self.text.encode() + source[self.end :]

    def stored(self) -> dict[str, Any]:
        """Return what identifies the place in a later version of the product."""
        names = ("kind", "file", "function", "before", "after", "ordinal")
        return {name: getattr(self, name) for name in names}


class Source:
    """The bytes of a module, by the positions of its syntax tree."""

    def __init__(self, data: bytes) -> None:
        self.data = data
        self._starts = [0]
        for line in data.splitlines(keepends=True):
            self._starts.append(self._starts[-1] + len(line))

    def span(self, node: Any) -> tuple[int, int]:
        """Return where a node begins and ends."""
        end = self._starts[node.end_lineno - 1] + node.end_col_offset
        return self._starts[node.lineno - 1] + node.col_offset, end

    def text(self, start: int, end: int) -> str:
        """Return a part of the text."""
        return self.data[start:end].decode()

    def lines(self, start: int, end: int, text: str) -> tuple[int, str, str]:
        """Return the number of the line of a change, and the whole lines before and after it."""
        first = self.data.rfind(b"\n", 0, start) + 1
        last = self.data.find(b"\n", end) % (len(self.data) + 1)
        head, tail = self.text(first, start), self.text(end, last)
        both = (head + self.text(start, end) + tail, head + text + tail)
        before, after = (" ".join(lines.split()) for lines in both)
        return self.data.count(b"\n", 0, start) + 1, before, after


Edit = tuple[str, int, int, str]


def edits(node: ast.AST, source: Source) -> Iterator[Edit]:
    """Yield what can be changed at a node: kind, start, end, new text."""
    match node:
        case ast.Compare(left=left, comparators=[right]):
            start, end = source.span(left)[1], source.span(right)[0]
            between = source.text(start, end)
            flipped = re.sub("[<>=!]=|[<>]", lambda sign: FLIPPED[sign[0]], between, count=1)
            if flipped != between:
                yield "comparison", start, end, flipped
        case ast.Expr(value=ast.Call() | ast.Await(value=ast.Call())):
            yield "call", *source.span(node), "pass"
        case ast.Call(args=[first, second, *_]) if _name(node) not in NOT_SWAPPED:
            (start, middle), (after, end) = source.span(first), source.span(second)
            texts = source.text(start, middle), source.text(middle, after), source.text(after, end)
            if texts[0] != texts[2] and not isinstance(first, ast.Starred):
                yield "arguments", start, end, "".join(reversed(texts))
        case ast.Constant(value=int() as value) if not isinstance(value, bool):
            yield "off by one", *source.span(node), str(value + 1)
        case ast.BoolOp(op=op, values=values):
            word, other = ("and", "or") if isinstance(op, ast.And) else ("or", "and")
            spans = [source.span(value) for value in values]
            text, at = "", spans[0][0]
            for start, end in spans:
                text += source.text(at, start).replace(word, other) + source.text(start, end)
                at = end
            yield "boolean", spans[0][0], at, text


def negations(node: ast.AST, source: Source) -> Iterator[Edit]:
    """Yield the conditions of a node that can be negated, like `edits`."""
    conditions: list[ast.expr] = []
    match node:
        case ast.If(test=test) | ast.While(test=test) | ast.IfExp(test=test):
            conditions = [] if isinstance(test, ast.Constant) else [test]
        case ast.comprehension(ifs=ifs):
            conditions = ifs
    for condition in conditions:
        match condition:
            case ast.UnaryOp(op=ast.Not(), operand=operand):
                negated = source.text(*source.span(operand))
            case _:
                negated = f"not ({source.text(*source.span(condition))})"
        yield "negation", *source.span(condition), negated


def _name(node: ast.AST) -> str:
    """Return the last name of what is called."""
    match node:
        case ast.Call(func=ast.Name(id=name) | ast.Attribute(attr=name)):
            return name
    return ""


def skipped(node: ast.AST) -> bool:
    """Tell whether a defect here would be in texts, logs, caches, or code that does not run."""
    match node:
        case ast.JoinedStr() | ast.Raise() | ast.Assert():
            return True
        case ast.Call(func=ast.Attribute(value=ast.Call(func=ast.Name(id="super")))):
            return True
        case ast.Call():
            return _name(node) in LOGGED
        case ast.Expr(value=ast.Await(value=call)) | ast.Expr(value=ast.Call() as call):
            return skipped(call)
        case ast.If(test=test):
            return re.search("TYPE_CHECKING|__name__", ast.unparse(test)) is not None
        case ast.Assign(targets=[ast.Name(id=name)]):
            return name in TEXTS
        case ast.FunctionDef(name=name, returns=returns):
            text = isinstance(returns, ast.Name) and returns.id == "str"
            return text or name in TEXT_ONLY or "cache" in name
    return False


def places(root: Path, folders: Iterable[str]) -> list[Place]:
    """Return all places of some folders."""
    files = sorted(file for folder in folders for file in (root / folder).rglob("*.py"))
    return [place for file in files for place in places_of(file, root)]


def places_of(file: Path, root: Path) -> Iterator[Place]:
    """Yield the places of a file, in the order of its syntax tree."""
    source = Source(file.read_bytes())
    counts: dict[tuple[str, str], int] = {}
    nodes: list[tuple[ast.AST, str]] = [(ast.parse(source.data), "")]
    while nodes:
        node, function = nodes.pop()
        if skipped(node):
            continue
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            function = f"{function}.{node.name}".removeprefix(".")
        for kind, start, end, text in (*edits(node, source), *negations(node, source)):
            ordinal = counts[function, kind] = counts.get((function, kind), -1) + 1
            line, before, after = source.lines(start, end, text)
            name = str(file.relative_to(root))
            yield Place(kind, name, function, before, after, ordinal, line, start, end, text)
        for name, value in reversed(list(ast.iter_fields(node))):
            if name not in NOT_RUN:
                parts = value if isinstance(value, list) else [value]
                nodes += [(part, function) for part in reversed(parts) if isinstance(part, ast.AST)]
