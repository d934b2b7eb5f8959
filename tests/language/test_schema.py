"""The JSON Schema for editors, against the missions that are here."""

from __future__ import annotations

import re
from pathlib import Path
from textwrap import indent
from typing import Any

import jsonschema
import pytest

from bt_mission.base.yaml.document import read, read_text
from bt_mission.language.nodes.registry import KINDS
from bt_mission.requirements.schema import mission_schema
from tests.support.project import LANGUAGE_PAGES, MISSIONS
from tests.support.thorough import sample

EXAMPLES = re.findall(r"```yaml\n(.*?)```", LANGUAGE_PAGES, re.DOTALL)


def as_mission(nodes: str) -> str:
    """A mission of these nodes."""
    return "mission: m\ntree:\n  sequence:\n" + indent(nodes, "    ")


@pytest.fixture(scope="module")
def validator() -> Any:
    """A validator of mission files."""
    schema = mission_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


@pytest.mark.parametrize("path", sample(MISSIONS, 4), ids=lambda path: path.stem)
def test_every_shipped_mission_is_valid(validator: Any, path: Path) -> None:
    """The schema refuses nothing that the loader takes."""
    validator.validate(read(path).data)


FOLLOW = "{topic: b, type: a/msg/B, field: x.y, as: b, initial: 1, default: 1, timeout: 2.5}"
OF_MISSION = "mission: m\nfollow: %s\ntree: {wait: 1}\n"
OF_TREE = "mission: m\ntrees: {t: {follow: %s, do: {wait: 1}}}\ntree: {tree: t}\n"
WHOLE = [text if text.startswith("mission:") else as_mission(text) for text in EXAMPLES]


@pytest.mark.parametrize(
    "text",
    sample(
        [form % follow for form in (OF_MISSION, OF_TREE) for follow in (FOLLOW, f"[{FOLLOW}]")]
        + WHOLE,
        3,
    ),
)
def test_what_is_written_as_on_the_page_is_valid(validator: Any, text: str) -> None:
    """Each kind and modifier stands in one of its examples; topics are followed in two places."""
    validator.validate(read_text(text).data)


@pytest.mark.parametrize(
    "text",
    [
        *(
            f"mission: m\ntree: {tree}\n"
            for tree in (
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
            )
        ),
        *(
            form % follow
            for form in (OF_MISSION, OF_TREE)
            for follow in (FOLLOW.replace("as: b, ", ""), FOLLOW.replace("initial", "qos"), "b")
        ),
        "misson: m\ntree: {wait: 1}\n",
        "mission: m\nmap: some\ntree: {wait: 1}\n",
        "mission: 3\ntree: {wait: 1}\n",
    ],
)
def test_usual_mistakes_are_seen_in_the_editor(validator: Any, text: str) -> None:
    """Keys, shapes and words; the rest is for `check`."""
    assert not validator.is_valid(read_text(text).data)


def test_every_kind_has_a_description() -> None:
    """An editor shows it."""
    definitions = mission_schema()["$defs"]
    assert all(definitions[f"kind_{kind}"]["description"] for kind in KINDS)
