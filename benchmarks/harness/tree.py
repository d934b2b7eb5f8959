"""The software that is measured: this checkout, or another commit in a temporary folder."""

from __future__ import annotations

import io
import os
import subprocess
import tarfile
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent

WITHOUT_EDITABLE = '''\
"""Let PYTHONPATH decide: an editable installation would bring its own checkout in before it."""
import sys

sys.meta_path[:] = [
    one
    for one in sys.meta_path
    if not type(one).__module__.startswith(("_editable_", "__editable_"))
]
'''
"""Read by every Python that is started with its folder on the path, once `site` is done."""


class TreeError(Exception):
    """A commit is not available."""


@dataclass(frozen=True)
class Tree:
    """A copy of the software that is measured.

    Args:
        root: Its folder.
        commit: What git calls it, with ``-dirty`` where files have changed since.
        path: Folders that come first on the path of Python.
    """

    root: Path
    commit: str
    path: tuple[Path, ...]

    def environment(self) -> dict[str, str]:
        """Return the variables with which a process imports this copy."""
        already = os.environ.get("PYTHONPATH", "").split(os.pathsep)
        kept = [folder for folder in already if folder and Path(folder).resolve() != ROOT]
        paths = [*map(str, self.path), *kept]
        return os.environ | {"PYTHONPATH": os.pathsep.join(paths)}


def this_tree() -> Tree:
    """Return the copy of this file."""
    try:
        commit = _git("describe", "--always", "--dirty").decode().strip()
    except TreeError:
        commit = "no git"
    return Tree(ROOT, commit, (ROOT,))


@contextmanager
def checked_out(revision: str) -> Iterator[Tree]:
    """Write another commit into a temporary folder, which is removed afterwards.

    Raises:
        TreeError: Where git does not know it.
    """
    try:
        commit = _git("rev-parse", "--verify", "--quiet", f"{revision}^{{commit}}").decode().strip()
    except TreeError as error:
        raise TreeError(
            f"git knows no commit '{revision}' here; name a commit, a tag or a branch, such as "
            "HEAD~1 (git log --oneline lists some)"
        ) from error
    with tempfile.TemporaryDirectory(prefix="benchmarks_") as name:
        root, first = Path(name).resolve() / "tree", Path(name).resolve() / "path"
        first.mkdir()
        (first / "sitecustomize.py").write_text(WITHOUT_EDITABLE, encoding="utf-8")
        with tarfile.open(fileobj=io.BytesIO(_git("archive", commit))) as files:
            files.extractall(root, filter="data")
        yield Tree(root, _git("describe", "--always", commit).decode().strip(), (first, root))


def _git(*arguments: str) -> bytes:
    command = ["git", "-C", str(ROOT), *arguments]
    try:
        done = subprocess.run(command, capture_output=True, check=False)  # noqa: S603 - git
    except FileNotFoundError as error:
        raise TreeError("git is not installed; --against needs it") from error
    if done.returncode:
        raise TreeError(f"git {arguments[0]}: {done.stderr.decode().strip() or 'failed'}")
    return done.stdout
