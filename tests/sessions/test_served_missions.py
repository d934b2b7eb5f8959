"""What clients of ``execute_mission`` reach, and what they do not."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest
from bt_mission_interfaces.action import ExecuteMission

from bt_mission.base.errors import BtMissionError
from bt_mission.sessions.served_missions import ServedMissions, folders_to_serve

HELLO = "mission: hello\ntree: {log: hello}\n"
HIDDEN = "swordfish: 'a token: swordfish'\n"
LEAF = """
import pathlib
from py_trees.behaviour import Behaviour
pathlib.Path(__file__).with_suffix(".ran").touch()
class Leaf(Behaviour):
    def update(self): ...
"""


@pytest.fixture
def inside(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder that is served; beside it lie a file with a secret, a mission and a leaf."""
    monkeypatch.chdir(tmp_path)
    for name in ("inside", "outside", "inside/deep"):
        (tmp_path / name).mkdir()
    for folder in (tmp_path, tmp_path / "outside"):
        (folder / "secret.yaml").write_text(HIDDEN)
        (folder / "hello.yaml").write_text(HELLO)
        (folder / "leaf.py").write_text(LEAF)
    (tmp_path / "inside/hello.yaml").write_text(HELLO)
    (tmp_path / "inside/deep/hello.yaml").write_text(HELLO)
    return tmp_path / "inside"


def refused(served: ServedMissions, **goal: Any) -> str:
    """Have a goal refused; gives what its client is told."""
    with pytest.raises(BtMissionError) as caught:
        served.load(ExecuteMission.Goal(seed=-1, **goal))
    return str(caught.value)


def write(folder: Path, text: str) -> str:
    """Write a mission; gives its path."""
    (folder / "m.yaml").write_text(text)
    return str(folder / "m.yaml")


@pytest.mark.parametrize(
    "path", ["hello", "hello.yaml", "deep/hello", "inside/hello.yaml", "inside/../inside/hello"]
)
def test_missions_of_the_folder_are_found(inside: Path, path: str) -> None:
    """By name, by their path in the folder, and by that from the working folder."""
    served = ServedMissions((Path("inside"),))
    assert served.load(ExecuteMission.Goal(path=path, seed=-1)).name == "hello"
    assert served.load(ExecuteMission.Goal(path=str(inside / "hello.yaml"))).name == "hello"


@pytest.mark.parametrize(
    "path",
    [
        *("../secret.yaml", "../outside/secret.yaml", "secret.yaml", "outside/secret.yaml"),
        *("/etc/passwd", "/etc/no_such_file", "link.yaml", "linked/secret.yaml", "ring.yaml"),
        *("explore", ".", "..", "\0", "a" * 5000, "deep"),
    ],
)
def test_nothing_else_is_found(inside: Path, path: str) -> None:
    """Whether it is there or not: the answer is the same, but for the path in it."""
    (inside / "link.yaml").symlink_to(inside.parent / "secret.yaml")
    (inside / "linked").symlink_to(inside.parent / "outside")
    (inside / "ring.yaml").symlink_to(inside / "ring.yaml")
    output = refused(ServedMissions((inside,)), path=path)
    assert "no such mission" in output
    assert "swordfish" not in output


def test_only_files_are_known(inside: Path) -> None:
    """Neither a pipe nor a folder is a mission, whatever its name."""
    os.mkfifo(inside / "pipe.yaml")
    (inside / "folder.yaml").mkdir()
    assert ServedMissions((inside,)).names() == ["hello"]


@pytest.mark.parametrize("entry", ["../secret.yaml", "link.yaml", "/etc/passwd", "../nothing.yaml"])
def test_an_include_leads_nowhere_else(inside: Path, entry: str) -> None:
    """Links are followed before that is judged, and nothing of the file is told."""
    (inside / "link.yaml").symlink_to(inside.parent / "secret.yaml")
    path = write(inside, f"mission: m\ninclude: [{entry}]\ntree: {{log: x}}\n")
    output = refused(ServedMissions((inside,)), path=path)
    assert f"no such file '{entry}'" in output
    assert "swordfish" not in output


def test_an_include_inside_is_read(inside: Path) -> None:
    """As for `run`."""
    (inside / "deep/parts.yaml").write_text("trees: {greet: {do: {log: hi}}}\n")
    path = write(inside, "mission: m\ninclude: [deep/parts.yaml]\ntree: {tree: greet}\n")
    assert ServedMissions((inside,)).load(ExecuteMission.Goal(path=path)).name == "m"


@pytest.mark.parametrize("key", ["world", "robot"])
@pytest.mark.parametrize("value", ["../secret.yaml", "link.yaml"])
def test_worlds_and_robots_outside_are_not_there(inside: Path, key: str, value: str) -> None:
    """Those that are known by name stay."""
    (inside / "link.yaml").symlink_to(inside.parent / "secret.yaml")
    path = write(inside, f"mission: m\n{key}: {value}\ntree: {{log: x}}\n")
    output = refused(ServedMissions((inside,)), path=path)
    assert f"unknown {key} '{value}'" in output
    known = write(inside, "mission: m\nworld: empty_arena\nrobot: burger\ntree: {log: x}\n")
    assert ServedMissions((inside,)).load(ExecuteMission.Goal(path=known)).robot == "burger"


def test_python_leaves_need_leave(inside: Path) -> None:
    """Refused at its place, without an import; the option that opens it is named."""
    (inside / "leaf.py").write_text(LEAF)
    path = write(inside, "mission: m\ntree: {python: 'leaf.py:Leaf'}\n")
    output = refused(ServedMissions((inside,)), path=path)
    assert "m.yaml:2:16: error: the Python leaf 'leaf.py:Leaf' is refused" in output
    assert "--allow-python" in output
    assert not (inside / "leaf.ran").exists()
    served = ServedMissions((inside,), allow_python=True)
    assert served.load(ExecuteMission.Goal(path=path)).name == "m"
    assert (inside / "leaf.ran").exists()


@pytest.mark.parametrize(
    ("target", "words"),
    [
        ("link.py:Leaf", "is outside the folder"),
        ("../leaf.py:Leaf", "is outside the folder"),
        ("antigravity:Leaf", "must not be imported here"),
        ("leaf:Leaf", "must not be imported here"),
        ("leaf", "unknown plug-in 'leaf'"),
    ],
)
def test_python_leaves_come_from_the_folders(
    inside: Path, monkeypatch: pytest.MonkeyPatch, target: str, words: str
) -> None:
    """Also with leave: no file beside them, no module of the environment."""
    monkeypatch.syspath_prepend(inside.parent)
    (inside / "link.py").symlink_to(inside.parent / "leaf.py")
    path = write(inside, f"mission: m\ntree: {{python: '{target}'}}\n")
    assert words in refused(ServedMissions((inside,), allow_python=True), path=path)
    assert not (inside.parent / "leaf.ran").exists()


def test_a_leaf_of_a_linked_mission_folder_is_not_served(inside: Path) -> None:
    """Two folders, one of which is served: a leaf may lie only in that one."""
    (inside / "m.yaml").write_text("mission: m\ntree: {python: 'leaf.py:Leaf'}\n")
    (inside / "deep/m.yaml").symlink_to(inside / "m.yaml")
    (inside / "leaf.py").write_text(LEAF)
    served = ServedMissions((inside / "deep",), allow_python=True)
    assert "no such mission" in refused(served, path="m")
    assert not (inside / "leaf.ran").exists()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("mission: m\ninclude: [hello.yaml]\ntree: {log: x}\n", "may not include files"),
        ("mission: m\ntree: {python: 'leaf.py:Leaf'}\n", "the Python leaf"),
        ("mission: m\ntree: {python: 'os:Leaf'}\n", "the Python leaf"),
        ("mission: m\nworld: secret.yaml\ntree: {log: x}\n", "unknown world 'secret.yaml'"),
        ("mission: m\nrobot: ./secret.yaml\ntree: {log: x}\n", "unknown robot './secret.yaml'"),
    ],
)
def test_a_text_brings_in_nothing(inside: Path, text: str, words: str) -> None:
    """Neither from the working folder nor with leave for the folders."""
    served = ServedMissions((inside, inside.parent), allow_python=True, allow_text=True)
    output = refused(served, text=text)
    assert words in output
    assert "swordfish" not in output
    assert not (inside.parent / "leaf.ran").exists()


def test_many_warnings_hide_no_python_leaf(inside: Path) -> None:
    """Faults are cut after 200; refusals are not among those."""
    lines = "".join(f"    - set: {{unread_{n}: 1}}\n" for n in range(300))
    text = f"mission: m\ntree:\n  sequence:\n{lines}    - python: leaf.py:Leaf\n"
    served = ServedMissions((inside.parent,), allow_text=True)
    assert "the Python leaf 'leaf.py:Leaf' is refused" in refused(served, text=text)


def test_texts_need_leave(inside: Path) -> None:
    """The option that opens them is named."""
    assert "--allow-text" in refused(ServedMissions((inside,)), text=HELLO)
    served = ServedMissions(allow_text=True)
    assert served.load(ExecuteMission.Goal(text=HELLO, seed=-1)).name == "hello"


def test_the_folders_to_serve(inside: Path) -> None:
    """Those chosen; else the working folder's, or where it has none those that are shipped."""
    assert folders_to_serve([inside]) == (inside,)
    assert [folder.name for folder in folders_to_serve([])] == ["missions"]
    assert folders_to_serve([]) != (Path("missions"),)
    Path("missions").mkdir()
    assert folders_to_serve([]) == (Path("missions"),)
    with pytest.raises(BtMissionError, match="nowhere: no such folder"):
        folders_to_serve([inside / "nowhere"])
