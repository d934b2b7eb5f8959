"""Renders templates of jinja2; every text in them is escaped.

A template is named by its path in this package. A page extends ``views/html/base.html``: it fills
the blocks `title`, `style` and `body`. ``{{ asset(path) }}`` puts a style sheet or a script into a
page, ``{{ data(value) }}`` puts JSON into a script element.
"""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from bt_mission.base.text import escape_markup

# Nothing may be fetched: everything that is named here must be in the page.
POLICY = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:"

_PACKAGE = Path(__file__).resolve().parents[2]


def render(template: str, **values: Any) -> str:
    """Return a page.

    Args:
        template: The path of the template in this package, such as ``views/html/base.html``.
        values: Its variables. Texts are escaped; one that is markup already is a `Markup`.
    """
    return _environment().get_template(template).render(values)


@cache
def _environment() -> Environment:
    made = Environment(
        loader=FileSystemLoader(_PACKAGE),
        autoescape=True,
        undefined=StrictUndefined,
        finalize=lambda value: Markup(escape_markup(value)) if type(value) is str else value,  # noqa: S704 - it is escaped
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    made.globals |= {"asset": _asset, "data": _data, "policy": POLICY}
    return made


def _asset(path: str) -> Markup:
    return Markup((_PACKAGE / path).read_text(encoding="utf-8"))  # noqa: S704 - a file of ours


def _data(value: Any) -> Markup:
    # No "<", so that no text in it can end the element.
    return Markup(json.dumps(value, separators=(",", ":")).replace("<", "\\u003c"))  # noqa: S704
