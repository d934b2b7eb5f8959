"""The JSON Schema for editors, against the missions that are here."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from bt_mission.core.yaml.document import read, read_text
from bt_mission.language.nodes.registry import KINDS
from bt_mission.language.schema import mission_schema
from tests.support.project import LANGUAGE_PAGES, MISSIONS

SHIPPED = MISSIONS
EXAMPLES = re.findall(r"```yaml\n(.*?)```", LANGUAGE_PAGES, re.DOTALL)


@pytest.fixture(scope="module")
def validator() -> Any:
    """A validator of mission files."""
    schema = mission_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_every_shipped_mission_is_valid(validator: Any, path: Path) -> None:
    """The schema refuses nothing that the loader takes."""
    validator.validate(read(path).data)


FOLLOW = (
    "mission: m\nfollow: {0}\ntree: {{wait: 1}}\n",
    "mission: m\ntrees: {{t: {{follow: {0}, do: {{wait: 1}}}}}}\ntree: {{tree: t}}\n",
)


@pytest.mark.parametrize("text", FOLLOW)
def test_a_variable_may_follow_a_topic(validator: Any, text: str) -> None:
    """One mapping or a list of them, of a mission and of a named tree."""
    entry = "{topic: b, type: a/msg/B, field: x.y, as: b, initial: 1, default: 1, timeout: 2.5}"
    for follow in (entry, f"[{entry}]"):
        validator.validate(read_text(text.format(follow)).data)
    for follow in (entry.replace("as: b, ", ""), entry.replace("initial", "qos"), "b"):
        assert not validator.is_valid(read_text(text.format(follow)).data)


@pytest.mark.parametrize("example", EXAMPLES)
def test_every_example_of_the_page_is_valid(validator: Any, example: str) -> None:
    """Each kind and modifier stands in one of them."""
    whole = example.startswith("mission:")
    indented = "".join(f"    {line}\n" for line in example.splitlines())
    text = example if whole else f"mission: m\ntree:\n  sequence:\n{indented}"
    validator.validate(read_text(text).data)


@pytest.mark.parametrize(
    "tree",
    [
        "{trun: {angle: 90}}",
        "{turn: {angle: 90}, timout: 3}",
        "{turn: {angle: 90}, wait: 3}",
        "{sequence: []}",
        "{sequence: [{wait: []}]}",
        "{sequence: {wait: 1}}",
        "{repeat: {count: 2}}",
        "{repeat: {counts: 2}, do: {wait: 1}}",
        "{parallel: [{wait: 1}], succeed_when: some}",
        "{sequence: [{wait: 1}], memory: 3}",
        "{force: running, do: {wait: 1}}",
        "{for_each: {a: [1], b: [2]}, do: {wait: 1}}",
        "{sequence: [{wait: 1}], timeout: 9}",
    ],
)
def test_usual_mistakes_are_seen_in_the_editor(validator: Any, tree: str) -> None:
    """Keys, shapes and words; the rest is for `check`."""
    data = read_text(f"mission: m\ntree: {tree}\n").data
    assert not validator.is_valid(data)


@pytest.mark.parametrize("head", ["misson: m", "mission: m\nmap: some", "mission: 3"])
def test_the_head_is_described_too(validator: Any, head: str) -> None:
    """With its keys and their values."""
    assert not validator.is_valid(read_text(f"{head}\ntree: {{wait: 1}}\n").data)


def test_every_kind_has_a_description() -> None:
    """An editor shows it."""
    definitions = mission_schema()["$defs"]
    for kind in KINDS:
        assert definitions[f"kind_{kind}"]["description"]
