"""What a person writes: every kind of node has a model, and a model can give a JSON Schema."""

import pytest
from pydantic import ValidationError

from bt_mission.language.action_names import ACTION_NAMES
from bt_mission.language.file import MissionFile
from bt_mission.language.nodes.action import GoalNode
from bt_mission.language.nodes.registry import KINDS


@pytest.mark.parametrize("kind", KINDS)
def test_a_kind_is_a_required_field_of_its_model(kind):
    """The key that names the kind; every other field has a default, apart from the children."""
    fields = KINDS[kind].model_fields
    required = {field.alias or name for name, field in fields.items() if field.is_required()}
    assert required - {"do", "then"} == {kind}


@pytest.mark.parametrize("kind", KINDS)
def test_every_model_gives_a_json_schema(kind):
    """Editors complete from it; unknown keys are marked."""
    schema = KINDS[kind].model_json_schema()
    assert schema["additionalProperties"] is False
    assert kind in schema["properties"]


def test_short_names_take_the_modifiers_of_every_action():
    """There is one list of them."""
    for name in ACTION_NAMES:
        assert issubclass(KINDS[name], GoalNode)


def test_models_are_frozen_and_strict():
    """Nothing is guessed, nothing changes."""
    written = MissionFile(mission="m", tree={})
    with pytest.raises(ValidationError):
        written.seed = 3  # type: ignore[misc]
    with pytest.raises(ValidationError):
        MissionFile(mission="m", tree={}, seed="3")  # type: ignore[arg-type]
