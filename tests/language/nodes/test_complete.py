"""A kind of node is complete: the test names what a new one still lacks, outside of its class."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any, ClassVar, cast

import pytest
from pydantic import Field

from bt_mission.base.diagnostics import InputError
from bt_mission.executive.behaviours import leaves
from bt_mission.executive.behaviours.builder import BEHAVIOURS, build_tree
from bt_mission.executive.behaviours.hooks import Hooked
from bt_mission.executive.behaviours.runtime import Scope
from bt_mission.language.mission import Mission
from bt_mission.language.nodes.base import Family, NodeModel, Sign
from bt_mission.language.nodes.fields import Seconds
from bt_mission.language.nodes.registry import GENERAL, KINDS
from bt_mission.sessions.load import load
from tests.support.project import LANGUAGE_PAGES, ROOT

CORPUS = ROOT / "tests" / "fuzz" / "corpus" / "every_kind.yaml"

BEHAVIOUR = "a behaviour in bt_mission.executive.behaviours.builder.BEHAVIOURS"
EXAMPLE = "a mission with it in tests/fuzz/corpus/every_kind.yaml"
PARAGRAPH = "a paragraph with an example in docs/reference/nodes.md"


def kinds_of(mission: Mission) -> set[str]:
    """The kinds of all nodes of a mission."""
    return {node.kind for tree in mission.all_trees for node in tree.body.walk()}


def lacking(key: str, corpus: Path, page: str) -> Iterator[str]:
    """What a kind of node lacks."""
    kind = KINDS[key].kind
    if not any(parent in BEHAVIOURS for parent in KINDS[key].__mro__):
        yield BEHAVIOUR
    if f"{key}:" not in page:
        yield PARAGRAPH
    if kind not in kinds_of(load(corpus)):
        yield EXAMPLE


@pytest.fixture
def corpus(tmp_path: Path) -> Path:
    """The mission with every kind, among the files that it uses."""
    shutil.copytree(CORPUS.parent / "beside", tmp_path, dirs_exist_ok=True)
    return Path(shutil.copy(CORPUS, tmp_path))


@pytest.mark.parametrize("key", GENERAL)
def test_a_kind_lacks_nothing(key: str, corpus: Path) -> None:
    """Its class tells the rest: form, values, variables, ends, label and details."""
    results = list(lacking(key, corpus, LANGUAGE_PAGES))
    assert results == [], "\n".join(results)


def test_every_behaviour_has_hooks(corpus: Path) -> None:
    """Breakpoints and faults reach each node, whatever its kind."""
    nodes = build_tree(load(corpus), Scope({}, 0)).iterate()
    assert [node.name for node in nodes if not isinstance(node, Hooked)] == []


class HonkNode(NodeModel):
    """A noise, for some seconds."""

    kind: ClassVar[str] = "honk"
    sign: ClassVar[Sign] = Sign("!", "!", "honk", Family.OTHER)

    seconds: Seconds = Field(alias="honk")


def test_what_a_new_kind_lacks_is_named(corpus: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """One by one, until it is there; a class in the registry is enough to write and check it."""
    monkeypatch.setitem(GENERAL, "honk", HonkNode)
    assert list(lacking("honk", corpus, LANGUAGE_PAGES)) == [BEHAVIOUR, PARAGRAPH, EXAMPLE]
    monkeypatch.setitem(cast("dict[Any, Any]", BEHAVIOURS), HonkNode, leaves.Wait)
    assert list(lacking("honk", corpus, LANGUAGE_PAGES)) == [PARAGRAPH, EXAMPLE]
    page = f"{LANGUAGE_PAGES}\n    honk: 2\n"
    assert list(lacking("honk", corpus, page)) == [EXAMPLE]
    corpus.write_text("mission: m\ntree: {honk: 2}\n", encoding="utf-8")
    assert list(lacking("honk", corpus, page)) == []
    assert build_tree(load(corpus), Scope({}, 0)).name == "honk"
    corpus.write_text("mission: m\ntree: {honk: -1}\n", encoding="utf-8")
    with pytest.raises(InputError, match="expected seconds, 0 or more, got the number -1"):
        load(corpus)
