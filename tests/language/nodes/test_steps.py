"""Steps are frozen data with a walk."""

import dataclasses

import pytest

from bt_mission.language.nodes import steps


def test_the_walk_is_in_the_order_of_the_file():
    """A node, then what is below it, then what is behind it."""
    first, second, third = (steps.WaitStep(seconds=n) for n in (1, 2, 3))
    tree = steps.SequenceStep(
        children=(
            first,
            steps.RepeatStep(count=2, child=steps.FallbackStep(children=(second,))),
            third,
        )
    )
    kinds = [step.kind for step in tree.walk()]
    assert kinds == ["sequence", "wait", "repeat", "fallback", "wait", "wait"]
    assert tree.steps[1].steps[0].steps == (second,)


def test_steps_are_frozen():
    """A tree that is built from them can trust them."""
    step = steps.WaitStep(seconds=1)
    with pytest.raises(dataclasses.FrozenInstanceError):
        step.seconds = 2  # type: ignore[misc]
