"""What is told instead of a word, a value or a modifier in the wrong place."""

from typing import Any

import pytest

from bt_mission.language.action_names import ACTION_NAMES, WORDS
from bt_mission.language.file import MissionFile, TreeDefinition
from bt_mission.language.nodes import remedies
from bt_mission.language.nodes.registry import KINDS
from bt_mission.ros.interface_types import shapes


def test_no_word_of_others_is_one_of_ours():
    """Else nobody would ever be told."""
    ours = {name for model in KINDS.values() for name in model.keys} | set(KINDS)
    assert not ours & set(remedies.OTHER_WORDS)
    assert all(remedies.bare_word(word) == word for word in remedies.OTHER_WORDS)


def test_a_key_of_other_tools_leads_to_one_of_ours():
    """That is one of the file, the tree or the node, and the other is not."""
    models: dict[str, Any] = {"mission": MissionFile, "tree": TreeDefinition}
    for owner, words in remedies.OTHER_KEYS.items():
        model: Any = models.get(owner) or KINDS[owner].model_fields["settings"].annotation
        ours = {info.alias or name for name, info in model.model_fields.items()}
        assert set(words.values()) <= ours
        assert not ours & set(words)
        assert all(remedies.bare_word(word) == word for word in words)


def test_no_action_of_a_package_has_the_name_of_another_kind_or_modifier():
    """Such a plug-in would change what missions mean that do not know it."""
    ours = {name for model in KINDS.values() for name in model.keys} | set(KINDS)
    assert ours - set(ACTION_NAMES) == WORDS


@pytest.mark.parametrize("kind", [*remedies.EXAMPLES, *ACTION_NAMES])
def test_the_field_that_is_meant_is_one_of_the_kind(kind):
    """Of the goal, or of the settings."""
    if kind in ACTION_NAMES:
        result = shapes(ACTION_NAMES[kind].type)
        assert next(iter(remedies.example_of(kind))) in result.sends.fields
    else:
        settings: Any = KINDS[kind].model_fields["settings"].annotation
        assert next(iter(remedies.example_of(kind))) in settings.model_fields


def test_a_long_value_is_not_repeated():
    """The line would be of no use."""
    result = remedies.lone_value("follow_waypoints", list(range(100)))
    hint = "write 'follow_waypoints: {poses: ...}'"
    assert result == ("expected a mapping, got a list of 100", hint)


@pytest.mark.parametrize("word", ["Else If", "else_if", "elseif", "ElseIf"])
def test_blanks_signs_and_capitals_do_not_matter(word):
    """All are one word."""
    assert remedies.unknown_modifier(word, ["do"]) == remedies.OTHER_MODIFIERS["elseif"]
