"""Check the prose of the project with textlint: pages, docstrings, help and messages.

The rules are in `tools/prose/`: phrases to avoid with what to write instead, and the length of a
sentence. Markdown is read as it is. From Python, the docstrings of public names and every text of
several words are read; these are help, errors, log lines and progress. The catalogue of errors
and the golden files of messages are read, too.

textlint and its rules are installed with npm below `--node` at first use. Without npm the check is
skipped with a message; where CI is set, that is an error.

Run it as: python tools/check_prose.py [PATH...]
"""

from __future__ import annotations

import argparse
import ast
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parent.parent
RULES = ROOT / "tools" / "prose"
PAGES = ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "docs")
CODE = ("bt_mission", "action_servers", "sim")
MESSAGES = (
    "bt_mission/base/error_catalogue.toml",
    *(path.relative_to(ROOT).as_posix() for path in ROOT.glob("bt_mission/commands/*/errors.toml")),
    "tests/executive/behaviours/transcripts",
    "tests/commands/convert/transcripts",
    "tests/cli/transcripts",
    "tests/language/broken",
    "tests/language/suspicious",
    "tests/language/transcripts",
)
"""The catalogues of errors, and files with the messages of commands as they are printed."""
LEAST_WORDS = 3
"""A text of fewer words is a name or a key."""

_WORD = re.compile(r"\b[A-Za-z][a-z']+\b")
_CATALOGUE_TEXT = re.compile(r'(title|cause|cure) = "(?P<text>.*)"')
_RULE = re.compile(r" *([a-z_]+ += | *\| )")
"""A line of a grammar."""
_SHELL = re.compile(r"\$[({\[]")
_OUTPUT = re.compile(r"(?! {4}|[$#] )\S*(?=.*\b[A-Za-z][a-z']+ [a-z']+ [a-z']+)")
"""A line of several words that is no command, comment, or excerpt of a file."""
_FUNCTIONS = ast.FunctionDef | ast.AsyncFunctionDef


class Finding(NamedTuple):
    """A place where a rule applies; `line` and `column` count from 1."""

    path: str
    line: int
    column: int
    message: str
    words: str


def main(arguments: list[str] | None = None) -> int:
    """Print the findings; return 1 if there are any, 2 if the linter cannot run."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("paths", nargs="*", metavar="PATH", help="only these files and folders")
    parser.add_argument(
        "--node", type=Path, default=ROOT / "build" / "prose", help="folder of textlint"
    )
    parser.add_argument(
        "--docstrings", action="store_true", help="of Python, read only the public docstrings"
    )
    options = parser.parse_args(arguments)
    npm = shutil.which("npm")
    if npm is None:
        print("prose is not checked: npm is not installed (Debian: apt install npm)")
        return 2 if os.environ.get("CI") else 0
    _install(npm, options.node)
    paths = [Path(path).resolve() for path in options.paths] or [
        ROOT / name for name in (*PAGES, *CODE, *MESSAGES)
    ]
    findings = sorted(_checked(paths, options.node, only_docstrings=options.docstrings))
    for finding in findings:
        words = f'"{finding.words}": ' if finding.words else ""
        print(f"{finding.path}:{finding.line}:{finding.column}: {words}{finding.message}")
    print(f"{len(findings)} findings" if findings else "no findings")
    return 1 if findings else 0


def _install(npm: str, folder: Path) -> None:
    package = RULES / "package.json"
    copy = folder / "package.json"
    if copy.is_file() and copy.read_bytes() == package.read_bytes():
        return
    folder.mkdir(parents=True, exist_ok=True)
    command = [npm, "install", "--no-package-lock", "--no-audit", "--no-fund", "--silent"]
    partial = folder / "package.json.part"
    shutil.copy(package, partial)
    subprocess.run(  # noqa: S603 - a fixed command
        [*command, "--prefix", str(folder), *_wanted(package)], check=True
    )
    partial.replace(copy)


def _wanted(package: Path) -> list[str]:
    wanted = json.loads(package.read_text("utf-8"))["dependencies"]
    return [f"{name}@{version}" for name, version in wanted.items()]


def _checked(
    paths: Iterable[Path], node: Path, *, only_docstrings: bool = False
) -> Iterator[Finding]:
    """Yield the findings of pages and of Python files."""
    pages: list[Path] = []
    shadows: dict[str, Path] = {}
    with tempfile.TemporaryDirectory() as folder:
        for path in paths:
            for file in _files(path):
                if file.suffix == ".md":
                    pages.append(file)
                    continue
                shadow = Path(folder) / f"{len(shadows)}.md"
                text = file.read_text("utf-8")
                if file.suffix == ".toml":
                    prose = shadow_of_catalogue(text)
                elif file.suffix == ".txt":
                    prose = shadow_of_output(text)
                else:
                    prose = shadow_of(text, only_docstrings=only_docstrings)
                shadow.write_text(prose, "utf-8")
                shadows[shadow.name] = file
        user_pages = [page for page in pages if page.is_relative_to(ROOT / "docs")]
        other_pages = [page for page in pages if page not in user_pages]
        for finding in _textlint(user_pages, "textlint.pages.json", node):
            yield finding._replace(path=_shown(Path(finding.path)))
        for finding in _textlint(other_pages, "textlint.json", node):
            yield finding._replace(path=_shown(Path(finding.path)))
        for is_output, config in ((False, "textlint.json"), (True, "textlint.output.json")):
            files = [
                Path(folder) / name
                for name, file in shadows.items()
                if (file.suffix == ".txt") is is_output
            ]
            for finding in _textlint(files, config, node):
                yield finding._replace(path=_shown(shadows[Path(finding.path).name]))


def _shown(path: Path) -> str:
    return path.relative_to(ROOT).as_posix() if path.is_relative_to(ROOT) else str(path)


def _files(path: Path) -> Iterator[Path]:
    if path.is_file():
        yield path
        return
    for file in sorted(path.rglob("*")):
        if file.suffix in (".md", ".py", ".txt") and "site" not in file.relative_to(path).parts:
            yield file


def _textlint(files: list[Path], config: str, node: Path) -> Iterator[Finding]:
    if not files:
        return
    command = [
        str(node / "node_modules" / ".bin" / "textlint"),
        *("--config", str(RULES / config), "--format", "json"),
        *("--rules-base-directory", str(node / "node_modules")),
    ]
    done = subprocess.run(  # noqa: S603 - a fixed command
        [*command, *map(str, files)], check=False, capture_output=True, text=True
    )
    try:
        answers = json.loads(done.stdout)
    except ValueError:
        sys.exit(f"textlint failed:\n{done.stdout}{done.stderr}")
    for answer in answers:
        text = Path(answer["filePath"]).read_text("utf-8")
        for message in answer["messages"]:
            begin, end = message.get("fix", message)["range"]
            is_phrase = message["ruleId"] == "prh"
            words = " ".join(text[begin:end].split()) if is_phrase else ""
            says = message["message"].splitlines()[0]
            advice = says.rpartition(" => ")[2] if is_phrase else "the sentence is too long"
            yield Finding(answer["filePath"], message["line"], message["column"], advice, words)


def shadow_of(source: str, *, only_docstrings: bool = False) -> str:
    """Return the prose of a Python file as Markdown, each text in the line where it begins."""
    lines = [""] * (source.count("\n") + 2)
    tree = ast.parse(source)
    docstrings = set()
    for node in ast.walk(tree):
        if not isinstance(node, ast.Module | ast.ClassDef | _FUNCTIONS) or not node.body:
            continue
        first = node.body[0]
        if isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant):
            docstrings.add(first.value)
            if isinstance(first.value.value, str) and not _is_private(node):
                for offset, line in enumerate(_without_examples(first.value.value)):
                    lines[first.value.lineno - 1 + offset] = _plain(line)
    if only_docstrings:
        return "\n".join(lines) + "\n"
    joined = [node for node in ast.walk(tree) if isinstance(node, ast.JoinedStr)]
    pieces = {part for node in joined for part in node.values}
    for node in ast.walk(tree):
        text = _text_of(node)
        if not isinstance(node, ast.expr) or node in docstrings | pieces:
            continue
        if len(_WORD.findall(text)) >= LEAST_WORDS and not _SHELL.search(text):
            before = lines[node.lineno - 1]
            lines[node.lineno - 1] = f"{before} {_sentence(_running(text))}".strip()
    return "\n".join(lines) + "\n"


def shadow_of_catalogue(source: str) -> str:
    """Return the title, cause and cure of each error, each in its line; examples are left out."""
    texts = (_CATALOGUE_TEXT.fullmatch(line) for line in source.splitlines())
    return "\n".join(_plain(text["text"]) if text else "" for text in texts) + "\n"


def shadow_of_output(source: str) -> str:
    """Return the messages of a golden file, each in its line, without commands and excerpts."""
    is_message = (_OUTPUT.match(line) is not None for line in source.splitlines())
    lines = zip(source.splitlines(), is_message, strict=True)
    return "\n".join(_sentence(_plain(line)) if wanted else "" for line, wanted in lines) + "\n"


def _running(text: str) -> str:
    """Return a text of several lines in one; a line that is indented is a sentence of its own."""
    running = ""
    for line in text.splitlines():
        ends = not line or line.startswith(" ")
        running = f"{_sentence(running) if ends else running} {_plain(line)}".strip()
        running = _sentence(running) if ends else running
    return running


def _sentence(text: str) -> str:
    return f"{text}." if text and text[-1] not in ".:!?" else text


def _without_examples(docstring: str) -> Iterator[str]:
    """Yield the lines of a docstring, those of grammars and of examples in code empty."""
    margin = 0
    in_code = False
    for line in docstring.splitlines():
        indent = len(line) - len(line.lstrip())
        in_code = in_code and (not line.strip() or indent > margin)
        yield "" if in_code or _RULE.match(line) else line
        if line.rstrip().endswith("::"):
            in_code, margin = True, indent


def _is_private(node: ast.AST) -> bool:
    name = getattr(node, "name", "")
    return name.startswith("_") and not name.endswith("__")


def _plain(line: str) -> str:
    """Return a line that Markdown reads as running text; names in code stay code."""
    line = re.sub(r":[a-z]+:`", "`", line.strip()).replace("``", "`")
    return re.sub(r"[<>#*|]", " ", line)


def _text_of(node: ast.AST) -> str:
    if isinstance(node, ast.JoinedStr):
        return "".join(
            str(part.value) if isinstance(part, ast.Constant) else "`N`" for part in node.values
        )
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    return ""


if __name__ == "__main__":
    sys.exit(main())
