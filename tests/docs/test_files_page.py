"""The page of keys is that of the models."""

from tools.make_key_tables import PAGE, page


def test_the_page_is_that_of_the_models() -> None:
    """Who changes a model writes the page again: `make generated`."""
    assert PAGE.read_text(encoding="utf-8") == page()
