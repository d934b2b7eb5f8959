"""XML files that include others, and what BehaviorTree.CPP 4.10 has besides."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from bt_mission.base.diagnostics import InputError
from bt_mission.commands.convert.document import document_of, mission_yaml
from bt_mission.language.permissions import Permissions
from bt_mission.sessions.check import examine
from bt_mission.sessions.load import load
from tests.support.missions import meaning

MAIN = """\
<root BTCPP_format="4" main_tree_to_execute="m">
<include path="{path}"{more}/>
<BehaviorTree ID="m"><Sequence><SubTree ID="say" what="hello"/><SubTree ID="far"/></Sequence>
</BehaviorTree>
<BehaviorTree ID="own"><AlwaysSuccess/></BehaviorTree>
</root>
"""
PARTS = """\
<root BTCPP_format="4">
<include path="deep/far.xml"/>
<BehaviorTree ID="say"><log message="{what}"/></BehaviorTree>
<TreeNodesModel><SubTree ID="say"><input_port name="what"/></SubTree></TreeNodesModel>
</root>
"""
FAR = """\
<root BTCPP_format="4">
<BehaviorTree ID="far"><SubTree ID="own"/></BehaviorTree>
</root>
"""


@pytest.fixture
def main(tmp_path: Path) -> Path:
    """A mission that includes a file beside it, which includes one in a folder below."""
    (tmp_path / "trees" / "deep").mkdir(parents=True)
    (tmp_path / "trees" / "parts.xml").write_text(PARTS)
    (tmp_path / "trees" / "deep" / "far.xml").write_text(FAR)
    path = tmp_path / "m.xml"
    path.write_text(MAIN.format(path="trees/parts.xml", more=""))
    return path


def faults_of(path: Path) -> list[tuple[str, int, int, str]]:
    """The faults of a file, each with the name of its file."""
    _, diagnostics = examine(path)
    return [
        (Path(diagnostic.file).name, diagnostic.line, diagnostic.column, diagnostic.message)
        for diagnostic in diagnostics
    ]


def test_the_trees_of_all_files_are_one_mission(main: Path) -> None:
    """Whichever way they use each other; a port without a type is a string."""
    mission, diagnostics = examine(main)
    assert mission is not None
    assert diagnostics == ()
    assert set(mission.trees) == {"say", "far", "own"}
    assert mission.trees["say"].types == {"what": "text"}
    names = [Path(document.file).name for document in mission.documents]
    assert names == ["m.xml", "parts.xml", "far.xml"]
    assert meaning(load(mission_yaml(main))) == meaning(mission)


def test_a_fault_is_in_the_file_that_has_it(main: Path) -> None:
    """At its line and column there."""
    (main.parent / "trees" / "deep" / "far.xml").write_text(FAR.replace("own", "nobody"))
    ((file, line, _, message),) = faults_of(main)
    assert (file, line) == ("far.xml", 2)
    assert message.startswith("unknown tree 'nobody'")
    (main.parent / "trees" / "deep" / "far.xml").write_text("<root")
    assert [fault[0] for fault in faults_of(main)][:1] == ["far.xml"]
    (main.parent / "trees" / "deep" / "far.xml").write_text(FAR.replace('"far"', '"own"'))
    messages = [message for *_, message in faults_of(main)]
    assert any(text.startswith("the tree 'own' already exists, in ") for text in messages)


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ("nowhere.xml", "no such file 'nowhere.xml' in the folder of the file that includes it"),
        ("../out.xml", "'../out.xml' is outside the folder of the file that includes it"),
        ("link.xml", "'link.xml' is outside the folder of the file that includes it"),
        ("/etc/passwd", "'/etc/passwd' is outside the folder of the file that includes it"),
        ("trees", "'trees' is not a file"),
        ("m.xml", "the files include each other: m.xml -> m.xml"),
    ],
)
def test_files_that_may_not_be_included(main: Path, path: str, message: str) -> None:
    """The rule of missions: below the file that includes, links followed."""
    folder = main.parent / "inner"
    folder.mkdir()
    (main.parent / "out.xml").write_text(FAR)
    (main.parent / "trees").rename(folder / "trees")
    (folder / "link.xml").symlink_to(main.parent / "out.xml")
    (folder / "m.xml").write_text(MAIN.format(path=path, more=""))
    file, line, column, output = faults_of(folder / "m.xml")[0]
    assert (file, line, column, output) == ("m.xml", 2, 15, message)


def test_a_package_is_looked_for_where_ros_is(
    main: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In its share folder, and not outside of it; a served mission includes none."""
    share = tmp_path / "prefix" / "share"
    (share / "my_trees" / "deep").mkdir(parents=True)
    (share / "ament_index/resource_index/packages").mkdir(parents=True)
    (share / "ament_index/resource_index/packages/my_trees").write_text("")
    (share / "my_trees" / "parts.xml").write_text(PARTS)
    (share / "my_trees" / "deep" / "far.xml").write_text(FAR)
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path / "prefix"))
    served = main.parent / "served"
    served.mkdir()
    main = served / "m.xml"
    main.write_text(MAIN.format(path="parts.xml", more=' ros_pkg="my_trees"'))
    assert set(load(main).trees) == {"say", "far", "own"}
    _, faults = examine(main, permissions=Permissions(folders=(served,)))
    assert any("no such file 'parts.xml'" in fault.message for fault in faults)
    main.write_text(MAIN.format(path="../x.xml", more=' ros_pkg="my_trees"'))
    assert faults_of(main)[0][3] == "no such file '../x.xml' in the package"


def test_a_recording_has_the_files(main: Path) -> None:
    """They are read from there, whatever is on the disk."""
    mission = load(main)
    texts = {
        mission.portable_name(read_document.file): read_document.text
        for read_document in mission.documents
    }
    assert list(texts) == ["m.xml", "trees/parts.xml", "trees/deep/far.xml"]
    document = document_of(texts["m.xml"], "m.xml", texts)
    again, _ = examine(document, permissions=Permissions(texts=texts))
    assert again is not None
    assert meaning(again) == meaning(mission)


# ---- what else BehaviorTree.CPP has ------------------------------------------------------------


def tree_of(nodes: str, models: str = "", trees: str = "") -> Any:
    """The tree of a mission with these nodes, as YAML has it."""
    models = f"<TreeNodesModel>{models}</TreeNodesModel>" if models else ""
    text = f'<root BTCPP_format="4" main_tree_to_execute="m"><BehaviorTree ID="m">{nodes}'
    return document_of(f"{text}</BehaviorTree>{trees}{models}</root>", "m.xml").data["tree"]


def test_remapped_ports_have_the_variables_of_their_names() -> None:
    """Those that are not given: inputs and outputs."""
    models = '<SubTree ID="s"><input_port name="a" type="double"/>'
    models += '<input_port name="b" type="double" default="1"/>'
    models += '<output_port name="c" type="double"/></SubTree>'
    trees = '<BehaviorTree ID="s"><Script code="c := a"/></BehaviorTree>'
    use = '<SubTree ID="s" a="2.0" _autoremap="true"/>'
    assert tree_of(use, models, trees) == {
        "tree": {"name": "s", "inputs": {"a": 2.0, "b": "$b"}},
        "outputs": {"c": "c"},
    }
    assert tree_of(use.replace("true", "false"), models, trees) == {
        "tree": {"name": "s", "inputs": {"a": 2.0}}
    }


def test_two_uses_of_a_tree_with_one_name_are_refused() -> None:
    """As by BehaviorTree.CPP, where they would have one path."""
    use = '<SubTree ID="s" name="x"/>'
    trees = '<BehaviorTree ID="s"><AlwaysSuccess/></BehaviorTree>'
    with pytest.raises(InputError, match="two SubTrees of this tree have the name 'x'"):
        tree_of(f"<Sequence>{use}{use}</Sequence>", "", trees)
