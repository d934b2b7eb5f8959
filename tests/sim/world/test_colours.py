"""Colours are names from a short list, or #rrggbb."""

import pytest

from sim.world.colours import NAMES, rgba


def test_hex_gives_parts_of_one():
    """Each pair of digits is a part of 255; alpha is 1."""
    assert rgba("#ff0033") == (1.0, 0.0, 0.2, 1.0)


def test_every_name_is_a_colour():
    """All names of the list are known."""
    assert all(rgba(name)[3] == 1.0 for name in NAMES)


@pytest.mark.parametrize("colour", ["gren", "#12345", "#12345g", "", "# 1 2 3"])
def test_unknown_colour_lists_the_known_ones(colour):
    """A colour that is neither gets the list."""
    with pytest.raises(ValueError, match=r"no such colour .* black, blue, .* or '#rrggbb'"):
        rgba(colour)


def test_unknown_colour_suggests_the_nearest():
    """A slip of the pen is met with the name that was meant."""
    with pytest.raises(ValueError, match="did you mean 'turquoise'"):
        rgba("turqoise")
