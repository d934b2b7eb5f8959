"""`bt-mission convert` from the command line; its messages are in ``cli/*.txt``."""

from __future__ import annotations

import re
import shutil
import textwrap
from pathlib import Path
from typing import Any, ClassVar, cast

import pytest
from pydantic import Field

from bt_mission.executive.behaviours import leaves
from bt_mission.executive.behaviours.builder import BEHAVIOURS
from bt_mission.language.nodes.base import Family, NodeModel, Sign
from bt_mission.language.nodes.fields import Seconds
from bt_mission.language.nodes.registry import GENERAL
from tests.support.command_line import CommandLine
from tests.support.project import ROOT

CORPUS = ROOT / "tests" / "fuzz" / "corpus"
ONLY_YAML = {"choose", "for_each", "finally"}
"""Kinds that XML of BehaviorTree.CPP has nothing for; others need a row in `table.py`."""


def test_a_shipped_mission_is_converted_by_its_name(cli: CommandLine) -> None:
    """As `run` and `check` take it."""
    assert '<BehaviorTree ID="square"' in cli("convert square")


def test_the_palette_of_a_mission_has_the_ports_that_it_uses(cli: CommandLine) -> None:
    """The palette alone does not know the fields of a service of any type."""
    port = '<input_port name="request__enabled"/>'
    service = "{name: /lamp, type: my_msgs/srv/Lamp, request: {enabled: true}}"
    cli.write("m.yaml", f"mission: m\ntree: {{service: {service}}}\n")
    palette = cli("convert --palette")
    assert '<input_port name="request__data"' in palette
    assert port not in palette
    assert port in cli("convert --palette m.yaml")


def test_every_kind_of_node_has_its_element(cli: CommandLine) -> None:
    """A leaf has it from its class; other nodes have a row."""
    shutil.copytree(CORPUS / "beside", cli.folder, dirs_exist_ok=True)
    shutil.copy(CORPUS / "every_kind.yaml", cli.folder)
    error = cli.refused("convert every_kind.yaml")
    without = {*re.findall(r"'(\w+)' has no counterpart in XML", error)}
    assert without & GENERAL.keys() == ONLY_YAML


class HonkNode(NodeModel):
    """A noise, for some seconds."""

    kind: ClassVar[str] = "honk"
    sign: ClassVar[Sign] = Sign("!", "!", "honk", Family.OTHER)

    seconds: Seconds = Field(alias="honk")


def test_the_element_of_a_new_leaf_follows_from_its_class(
    cli: CommandLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It needs no row."""
    monkeypatch.setitem(GENERAL, "honk", HonkNode)
    monkeypatch.setitem(cast("dict[Any, Any]", BEHAVIOURS), HonkNode, leaves.Wait)
    cli.write("m.yaml", "mission: m\ntree: {honk: 2}\n")
    assert '<honk seconds="2"/>' in cli("convert m.yaml")


def test_a_tree_of_behaviortree_cpp_becomes_a_tested_mission(
    pytester: pytest.Pytester, cli: CommandLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The tree of the page, its leaves replaced as the page says, passes the test of the page."""
    text = (ROOT / "docs/how-to/coming-from.md").read_text(encoding="utf-8")
    _, tree = re.findall(r"```xml to_a.xml\n(.*?)```", text, re.DOTALL)
    (test,) = re.findall(r"   ```python test_to_a.py\n(.*?)```", text, re.DOTALL)
    monkeypatch.chdir(pytester.path)
    Path("to_a.xml").write_text(textwrap.dedent(tree), encoding="utf-8")
    cli("convert to_a.xml -o to_a.yaml")
    Path("test_to_a.py").write_text(textwrap.dedent(test), encoding="utf-8")
    pytester.runpytest("-p", "no:cacheprovider").assert_outcomes(passed=1)
