#!/usr/bin/env python3
"""Build the documentation site: a folder for each version, and versions.json, which names them.

The pages of the working tree are always built, and must be without a warning. Further versions are
references of git (tags, branches); each is built as it was, with the settings of today.
"""

from __future__ import annotations

import argparse
import io
import json
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
MARK = "versions.json"
"""The file by which a folder is known as one with a site."""
SETTINGS = ROOT / "docs" / "site"
REDIRECT = (
    '<!doctype html><title>bt-mission</title><meta http-equiv="refresh" content="0; url={}/">\n'
)


def run(*command: str | Path) -> bytes:
    """Return what a command prints; its errors go to the terminal."""
    words = [str(word) for word in command]
    return subprocess.run(words, check=True, stdout=subprocess.PIPE).stdout  # noqa: S603 - our words


def version_of(source: Path) -> str:
    """Return the version that a source tree says it is."""
    project = tomllib.loads((source / "pyproject.toml").read_text("utf-8"))["project"]
    return str(project["version"])


def build(source: Path, into: Path, *, is_strict: bool) -> None:
    """Build the pages of one source tree, with a warning as an error where it is strict."""
    settings = ("-c", SETTINGS, "-D", f"html_title=bt-mission {into.name}")
    strictness = ("--fail-on-warning",) if is_strict else ()
    with tempfile.TemporaryDirectory() as caches:
        sphinx = (sys.executable, "-m", "sphinx", "-q", "-E", "-b", "html", "-d", caches)
        run(*sphinx, *settings, *strictness, source, into)


def commit_of(reference: str) -> str:
    """Return the commit that a reference of git names, whatever sign it begins with."""
    named = f"{reference}^{{commit}}"
    output = run("git", "-C", ROOT, "rev-parse", "--verify", "--end-of-options", named)
    return output.decode().split()[-1]


def export(reference: str, into: Path) -> None:
    """Write the sources of a reference of git into a folder."""
    packed = run("git", "-C", ROOT, "archive", commit_of(reference))
    with tarfile.open(fileobj=io.BytesIO(packed)) as files:
        files.extractall(into, filter="data")


def is_replaceable(folder: Path) -> bool:
    """Return whether a folder has nothing but a site: it is built anew as a whole."""
    return (folder / MARK).is_file() or not any(folder.iterdir())


def main() -> int:
    """Build what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("references", nargs="*", help="further versions, the newest first")
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "build" / "site")
    options = parser.parse_args()
    output: Path = options.output
    if output.exists() and not (output.is_dir() and is_replaceable(output)):
        parser.error(f"{output} is no folder with a site: remove it, or give another")
    try:
        for reference in options.references:
            commit_of(reference)
    except subprocess.CalledProcessError:
        parser.error(f"git knows no {reference!r}: expected tags, branches or commits")
    shutil.rmtree(output, ignore_errors=True)
    output.mkdir(parents=True)
    (output / MARK).write_text("[]", encoding="utf-8")
    newest = version_of(ROOT)
    names = [newest]
    try:
        build(ROOT, output / newest, is_strict=True)
        for reference in options.references:
            name = re.sub(r"[^\w.-]", "-", reference)
            with tempfile.TemporaryDirectory() as folder:
                export(reference, Path(folder))
                build(Path(folder), output / name, is_strict=False)
            names.append(name)
    except subprocess.CalledProcessError as error:
        print(f"the site was not built: {' '.join(error.cmd[:3])} ... failed", file=sys.stderr)
        return 1
    (output / MARK).write_text(json.dumps(names), encoding="utf-8")
    (output / "index.html").write_text(REDIRECT.format(newest), encoding="utf-8")
    print(output / "index.html")
    return 0


if __name__ == "__main__":
    sys.exit(main())
