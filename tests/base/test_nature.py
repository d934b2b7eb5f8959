"""Nature: its profiles, its draws, and how it is written."""

from __future__ import annotations

import statistics

import pytest
from pydantic_core import PydanticCustomError

from bt_mission.base.nature import BY_NAME, NO_NATURE, QUANTITIES, USUAL, Nature
from bt_mission.base.nature_field import read_nature


def test_without_a_profile_nothing_is_drawn():
    """Nor by `none` with a seed."""
    assert NO_NATURE.drawn(3) == {}


def test_a_draw_follows_from_seed_and_name_alone():
    """Each quantity and each robot has its own generator."""
    drawn = USUAL.drawn(3)
    assert drawn == USUAL.drawn(3)
    assert set(drawn) == set(BY_NAME)
    fixed = Nature("usual", {"lidar_noise": 0.5}).drawn(3)
    assert fixed == drawn | {"lidar_noise": 0.5}
    assert all(USUAL.drawn(4)[name] != value for name, value in drawn.items())
    assert USUAL.drawn(3, "robot1")["start_x"] != drawn["start_x"]


@pytest.mark.parametrize("quantity", QUANTITIES, ids=lambda quantity: quantity.name)
def test_draws_have_the_shape_that_is_declared(quantity):
    """A normal one has its standard deviation, another its ends; each fits its limits."""
    values = [USUAL.drawn(seed)[quantity.name] for seed in range(300)]
    assert all(quantity.least <= value <= quantity.most for value in values)
    low, high = min(values), max(values)
    match quantity.shape:
        case "normal":
            assert -2 * quantity.usual < low < high < 2 * quantity.usual
            assert statistics.stdev(values) == pytest.approx(0.88 * quantity.usual, rel=0.1)
        case "up to":
            assert 0 <= low < 0.1 * quantity.usual
            assert 0.9 * quantity.usual < high <= quantity.usual
        case "down to":
            assert quantity.usual <= low < high <= 1


def test_profiles_grow():
    """Harsh is at least as much as usual, usual as mild."""
    for quantity in QUANTITIES:
        order = [quantity.mild, quantity.usual, quantity.harsh]
        assert order == sorted(order, reverse=quantity.shape == "down to")


@pytest.mark.parametrize(
    ("written", "nature"),
    [
        ("usual", USUAL),
        ({"profile": "mild", "lidar_noise": 0.02}, Nature("mild", {"lidar_noise": 0.02})),
        ({"lidar_noise": "2 cm"}, Nature("none", {"lidar_noise": 0.02})),
        ({"topic_latency": "20 ms", "wheel_radius": "1 %"},
         Nature("none", {"topic_latency": 0.02, "wheel_radius": 1.0})),
    ],
)  # fmt: skip
def test_it_is_a_profile_or_a_mapping(written, nature):
    """A number may have a unit."""
    assert read_nature(written) == nature
    assert read_nature(nature.written) == nature


@pytest.mark.parametrize(
    ("written", "words"),
    [
        ("usuall", "harsh, got string 'usuall'"),
        ({"profile": 3}, "expected a profile of none, mild, usual, harsh, got the number 3"),
        (["usual"], "or a mapping, got a list"),
        ({"lidar_nois": 1}, "unknown quantity 'lidar_nois'"),
        ({"lidar_noise": "2 s"}, "expected a number, or one with a unit of m, cm, mm"),
        ({"lidar_noise": True}, "lidar_noise: expected a number"),
        ({"wheel_grip": 2}, "wheel_grip: expected 0 to 1, got the number 2"),
        ({"lidar_noise": float("nan")}, "lidar_noise: expected 0 to 1 m"),
    ],
)
def test_what_is_invalid_is_refused(written, words):
    """With what is expected."""
    with pytest.raises(PydanticCustomError) as caught:
        read_nature(written)
    assert words in caught.value.message()
