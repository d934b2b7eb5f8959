"""The picture of the packages in docs/architecture.md."""

from tools.draw_layers import PICTURE, draw


def test_the_picture_is_that_of_the_code():
    """Who changes the packages draws the picture again: `make generated`."""
    assert PICTURE.read_text(encoding="utf-8") == draw()
