"""The page about nature."""

from __future__ import annotations

from tools.make_nature_table import PAGE, with_table


def test_the_table_is_that_of_the_code() -> None:
    """`make generated` writes it."""
    page = PAGE.read_text(encoding="utf-8")
    assert with_table(page) == page
