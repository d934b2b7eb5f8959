"""Completion, hover and definitions in a mission that is being written."""

from __future__ import annotations

import re

import pytest

from bt_mission.commands.edit.completion import (
    LONGEST_LINE,
    LongLineError,
    completion,
    definition,
    hover,
)

TEXT = """\
mission: explore
world: dqn_stage|1
inputs:
  speed: 0.2
trees:
  look: {do: {wait: 1}}
tree:
  sequence:
    - explore_forward: {fwd_velocity: $sp|2, stop|3}
      name: drive
      on_cancel: |4
      cancel_when: cur|5
      ti|6
      outputs: {closest|7}
    - tu|8
    - tree: |9
    - repeat: {cou|10}
      do:
        wa|11
"""

EXPECTED = {
    1: ["dqn_stage1", "dqn_stage2", "dqn_stage3", "dqn_stage4"],
    2: ["speed"],
    3: ["stopping_distance"],
    4: ["success", "failure"],
    5: ["current_distance_travelled"],
    6: ["timeout"],
    7: ["closest_obstacle", "closest_obstacle_angle"],
    8: ["turn"],
    9: ["look"],
    10: ["count"],
    11: ["wait_for", "wait"],
}


PARTS = re.split(r"\|\d+", TEXT)
"""The text between its marks, which are numbered in their order."""


@pytest.mark.parametrize("number", EXPECTED)
def test_words_fit_their_place(number: int) -> None:
    """Keys, options, names of the mission and of what is installed."""
    proposed = completion("".join(PARTS), len("".join(PARTS[:number])))
    options = [option.label for option in proposed.options]
    assert options[: len(EXPECTED[number])] == EXPECTED[number]


@pytest.mark.parametrize(
    "line",
    ["a", *"[{ -'.", "- ", "a: {", "a:  [", "set: {", "a #", "outputs: {a: ", "trees: {look: "],
)
def test_the_longest_line_is_read_once(line: str) -> None:
    """Also among long lines above and below; of a line that is longer the error says so."""
    long = line * (LONGEST_LINE // len(line))
    above, below = f"tree:\n{line * 50_000}\n", f"!\n{line * 50_000}\n"
    completion(f"{above}{long}{below}", len(above) + len(long))
    definition(f"{above}{long}{below}", len(above) + len(long))
    with pytest.raises(LongLineError, match=r"line 3: no completion behind 10,000 characters"):
        completion(f"{above}{'x' * 32_000}", len(above) + 32_000)


def test_hover_says_unit_range_and_meaning() -> None:
    """They are those that the servers declare."""
    text = "".join(PARTS)
    word = hover(text, text.index("fwd_velocity") + 3)
    assert word is not None
    assert word.detail == "from 0.01 to 0.26 m/s"
    assert word.text == "forward speed; above zero, within the robot's limit"
    assert hover(text, text.index("explore\n")) is None


def test_definitions_are_found() -> None:
    """Of a named tree and of an input, by their uses."""
    text = "inputs:\n  speed: 1\ntrees:\n  look: {do: {wait: $speed}}\ntree: {tree: look}\n"
    assert definition(text, text.index("$speed") + 3) == text.index("speed")
    assert definition(text, text.rindex("look") + 1) == text.index("look")
