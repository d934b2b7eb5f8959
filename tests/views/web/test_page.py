"""The files of the page fit each other; no browser is needed to see that."""

from __future__ import annotations

import re
from importlib.resources import files


def test_every_key_of_the_page_is_listed_on_it():
    """In the lists that it shows, and at the button that does the same."""
    page = files("bt_mission.views.web") / "page"
    scripts, markup = ((page / name).read_text("utf-8") for name in ("app.js", "index.html"))
    listed = "".join(re.findall(r"<kbd>(.*?)</kbd>", markup))
    keys = {
        name: key.strip('"')
        for line in re.findall(r"_KEYS = \{ (.*) \};", scripts)
        for key, name in re.findall(r'("?[^\s,"]+"?): "([\w-]+)"', line)
    }
    assert len(keys) == 13
    for name, key in keys.items():
        assert key in listed, name
        assert f'id="{name}" aria-keyshortcuts="{key}"' in markup
