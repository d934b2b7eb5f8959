"""The JSON Schema of scenarios, against those that are here."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import jsonschema
import pytest
import yaml  # type: ignore[import-untyped]

from bt_mission.base.yaml.document import read, read_text
from bt_mission.scenarios.schema import scenario_schema
from tests.support.project import ROOT, SCENARIOS

PAGE = (ROOT / "docs" / "reference" / "scenarios.md").read_text(encoding="utf-8")
EXAMPLES = re.findall(r"```yaml-scenario\n(.*?)```", PAGE, re.DOTALL)
HEAD = {"scenario": "it", "mission": "explore"}


@pytest.fixture(scope="module")
def validator() -> Any:
    """A validator of scenario files."""
    schema = scenario_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


@pytest.mark.parametrize("path", SCENARIOS, ids=lambda path: path.stem)
def test_every_shipped_scenario_is_valid(validator: Any, path: Path) -> None:
    """The schema refuses nothing that the loader takes."""
    validator.validate(read(path).data)


def test_a_fault_without_quotes_is_valid_for_other_readers_of_yaml(validator: Any) -> None:
    """They take it for a mapping of one key."""
    faults = "- at 5.0: drop scan\n- when distance > 1 m: imu_dead\n"
    validator.validate({**HEAD, "faults": yaml.safe_load(faults)})


@pytest.mark.parametrize("text", EXAMPLES)
def test_every_example_of_the_page_is_valid(validator: Any, text: str) -> None:
    """Each whole file of it."""
    validator.validate(read_text(text).data)


def test_obstacles_are_described(validator: Any) -> None:
    """With its arguments."""
    definitions = validator.schema["$defs"]
    assert {"at", "size"} <= definitions["fault_spawn_box"]["properties"].keys()


@pytest.mark.parametrize(
    "wrong",
    [
        {"sed": 1},
        {"faults": [{"at": 5, "drp": "scan"}]},
        {"faults": [{"at": 5, "drop": {"topic": "scan", "shar": 1}}]},
        {"faults": ["drop scan"]},
        {"obstacles": [{"siz": [1, 1, 1]}]},
        {"expect": {"outcome": "fail"}},
        {"start": {"z": 1}},
    ],
)
def test_what_is_misspelled_is_refused(validator: Any, wrong: dict[str, Any]) -> None:
    """So that an editor marks it."""
    validator.validate(HEAD)
    assert not validator.is_valid({**HEAD, **wrong})
