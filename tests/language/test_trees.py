"""Named trees and included files, as they are gathered."""

from pathlib import Path

import pytest

from bt_mission.base.diagnostics import InputError
from bt_mission.base.files import folders
from bt_mission.executive.behaviours.builder import build_tree
from bt_mission.executive.behaviours.runtime import Scope
from bt_mission.language.trees import MOST_FILES, used
from bt_mission.sessions.check import examine
from bt_mission.sessions.load import load

LIBRARY = "trees:\n  rest: {inputs: {seconds: 1}, do: {wait: $seconds}}\n"


def write(folder: Path, **files: str) -> Path:
    """Write YAML files into a folder, `a__b` as `a/b`; gives the mission's path."""
    for name, text in files.items():
        path = folder / f"{name.replace('__', '/')}.yaml"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return folder / "mission.yaml"


def mission(include: str, tree: str = "{tree: rest}") -> str:
    """A mission that includes files."""
    return f"mission: m\ninclude: [{include}]\ntree: {tree}\n"


def refusal(path: Path) -> str:
    """The first line of what is said of a mission."""
    with pytest.raises(InputError) as caught:
        load(path)
    return str(caught.value).splitlines()[0].replace(f"{path.parent}/", "")


def test_trees_come_from_files_beside_and_below(tmp_path):
    """And from the files that those include, each relative to its own place."""
    path = write(
        tmp_path,
        mission=mission("parts/one.yaml"),
        parts__one="include: [two.yaml]\n",
        parts__two=LIBRARY,
    )
    loaded = load(path)
    assert list(loaded.trees) == ["rest"]
    assert Path(loaded.trees["rest"].document.file) == tmp_path / "parts" / "two.yaml"
    assert list(used(loaded)) == ["rest"]
    assert examine(path)[1] == ()


def test_a_file_is_read_once_however_often_it_is_included(tmp_path):
    """Two that include the same are no ring."""
    path = write(
        tmp_path,
        mission=mission("a.yaml, b.yaml, c.yaml"),
        a="include: [c.yaml]\n",
        b="include: [c.yaml]\n",
        c=LIBRARY,
    )
    assert list(load(path).trees) == ["rest"]


def test_the_mission_itself_cannot_be_included(tmp_path):
    """It would include itself."""
    path = write(tmp_path, mission=mission("mission.yaml"))
    assert "mission.yaml -> mission.yaml" in refusal(path)


def test_a_link_is_followed(tmp_path):
    """Within the folder it is as good as the file; others are in test_hostile."""
    path = write(tmp_path, mission=mission("link.yaml"), lib=LIBRARY)
    (tmp_path / "link.yaml").symlink_to(tmp_path / "lib.yaml")
    assert list(load(path).trees) == ["rest"]


def test_a_text_includes_shipped_missions_only(tmp_path, monkeypatch):
    """It has no folder of its own."""
    monkeypatch.chdir(tmp_path)
    write(tmp_path, lib=LIBRARY)
    write(tmp_path / "missions", shared=LIBRARY)
    with pytest.raises(InputError, match=r"no such file 'lib\.yaml'"):
        load(mission("lib.yaml"))
    assert list(load(mission("shared.yaml")).trees) == ["rest"]
    assert folders("missions")[0] == Path("missions")


def test_files_are_counted(tmp_path):
    """A chain of files without end is refused."""
    files = {f"f{n}": f"include: [f{n + 1}.yaml]\n" for n in range(MOST_FILES + 1)}
    path = write(tmp_path, mission=mission("f0.yaml", "{wait: 1}"), **files)
    assert refusal(path) == (
        f"f{MOST_FILES - 1}.yaml:1:11: error: more than {MOST_FILES} included files, which is "
        f"the limit [BT-112]"
    )


def test_entries_are_counted(tmp_path):
    """Also those of one file."""
    entries = ", ".join(["lib.yaml"] * (MOST_FILES + 1))
    path = write(tmp_path, mission=mission(entries, "{wait: 1}"), lib=LIBRARY)
    assert f"more than {MOST_FILES} included files, which is the limit" in refusal(path)


def chained(count: int, depth: int = 1) -> str:
    """A mission whose trees each use the next, within so many nodes."""
    use = "{{invert: " * (depth - 1) + "{{tree: t{0}}}" + "}}" * (depth - 1)
    trees = "".join(f"  t{i}: {{do: {use.format(i + 1)}}}\n" for i in range(count))
    return f"mission: m\ntrees:\n{trees}  t{count}: {{do: {{wait: 1}}}}\ntree: {{tree: t0}}\n"


def test_levels_are_counted_through_trees():
    """A tick goes down them in Python's own calls, of which there are a thousand."""
    loaded = load(chained(198))
    assert len(list(build_tree(loaded, Scope({}, 0)).iterate())) == 200
    with pytest.raises(InputError) as caught:
        load(chained(2_000, depth=3))
    assert str(caught.value).splitlines()[0] == (
        "<text>:2004:1: error: the mission has 6,002 levels of nodes with the trees it uses; "
        "the limit is 200 [BT-209]"
    )


def test_a_ring_of_thousands_is_found():
    """In one pass: what a tree uses is looked at once."""
    with pytest.raises(InputError) as caught:
        load(chained(3_000).replace("{do: {wait: 1}}", "{do: {tree: t17}}"))
    (fault,) = caught.value.diagnostics
    way = " -> ".join(f"t{number}" for number in range(100, 120))
    assert fault.message == f"a tree cannot use itself: {way} -> ... -> t100"


def test_a_tree_that_nobody_uses_is_warned_of_in_the_mission_alone(tmp_path):
    """A library may hold more than one mission needs; what it holds is checked all the same."""
    extra = "  more: {do: {log: x}}\n  empty: {do: {log: $y}}\n"
    path = write(
        tmp_path,
        mission=mission("lib.yaml") + "trees:\n  idle: {do: {wait: 1}}\n",
        lib=LIBRARY + "  more: {do: {turn: {}}}\n",
    )
    loaded = load(path)
    assert [
        str(warning).splitlines()[0].partition("warning: ")[2] for warning in loaded.warnings
    ] == ["the tree 'idle' is never used [BT-231]"]
    write(tmp_path, lib=LIBRARY + extra)
    assert "'$y' is an undefined variable" in refusal(path)
