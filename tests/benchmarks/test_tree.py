"""Another commit is there for a while."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks.harness import tree
from benchmarks.harness.tree import WITHOUT_EDITABLE, Tree, TreeError, checked_out


@pytest.fixture
def repository(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A repository with two commits, of which the first says `old`."""
    root = tmp_path / "repository"
    root.mkdir()
    names = ("-c", "user.name=somebody", "-c", "user.email=a@example.org")
    git("init", "-q", at=root)
    for word in ("old", "new"):
        (root / "word.txt").write_text(word, encoding="utf-8")
        git("add", ".", at=root)
        git(*names, "commit", "-q", "-m", word, at=root)
    monkeypatch.setattr(tree, "ROOT", root)
    return root


def git(*arguments: str, at: Path) -> str:
    """What git says."""
    command = ["git", "-C", str(at), *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def test_a_commit_is_checked_out_and_gone_afterwards(repository):
    """The checkout itself stays as it is."""
    with checked_out("HEAD~1") as old:
        assert (old.root / "word.txt").read_text() == "old"
        assert (repository / "word.txt").read_text() == "new"
    assert not old.root.exists()
    assert len(git("worktree", "list", at=repository).splitlines()) == 1


def test_an_interrupt_leaves_nothing(repository):
    """As Ctrl-C does in the middle of a measurement."""

    def interrupted() -> None:
        with checked_out("HEAD~1") as old:
            places.append(old.root)
            raise KeyboardInterrupt

    places: list[Path] = []
    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert not places[0].exists()
    assert len(git("worktree", "list", at=repository).splitlines()) == 1


def test_a_commit_that_is_not_there_is_named(repository):
    """With what could be meant."""
    with pytest.raises(
        TreeError, match=r"git knows no commit 'nothing' here; name a commit, a tag"
    ):
        checked_out("nothing").__enter__()


def test_a_folder_without_git_is_told(tmp_path: Path, monkeypatch):
    """Such as an unpacked archive."""
    monkeypatch.setattr(tree, "ROOT", tmp_path)
    with pytest.raises(TreeError):
        checked_out("HEAD").__enter__()


def test_the_copy_comes_first_on_the_path(monkeypatch):
    """And this checkout leaves the path that it has been put on."""
    monkeypatch.setenv("PYTHONPATH", f"/more:{tree.ROOT}")
    old = Tree(Path("/old"), "old", (Path("/first"), Path("/old")))
    assert old.environment()["PYTHONPATH"] == "/first:/old:/more"


def test_an_editable_installation_does_not_come_before_the_copy(monkeypatch):
    """Its finder is taken out; the others stay."""
    editable = type("F", (), {"__module__": "_editable_skbc_bt_mission"})()
    other = type("F", (), {"__module__": "_distutils_hack"})()
    monkeypatch.setattr(sys, "meta_path", [editable, other])
    exec(WITHOUT_EDITABLE, {})  # noqa: S102 - what every Python of the copy runs
    assert sys.meta_path == [other]
