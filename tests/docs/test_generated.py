"""What docs/ takes from the code is what the code says."""

from __future__ import annotations

import pytest

from tools.make_generated import GENERATED


@pytest.mark.parametrize("path", GENERATED, ids=lambda path: path.name)
def test_a_generated_file_is_up_to_date(path):
    """`make generated` writes it."""
    page = path.read_text(encoding="utf-8")
    assert GENERATED[path](page) == page
