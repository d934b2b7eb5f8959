"""HTML and SVG as text: escaping, attributes, short numbers."""

from __future__ import annotations

from collections.abc import Iterable

from bt_mission.core.text import escape_markup


def element(tag: str, content: str = "", /, **attributes: object) -> str:
    """An element around markup; `class_` and `data_x` are written `class` and `data-x`."""
    return f"<{tag}{_attributes(attributes)}>{content}</{tag}>"


def void(tag: str, /, **attributes: object) -> str:
    """An element of SVG without content."""
    return f"<{tag}{_attributes(attributes)}/>"


def _attributes(attributes: dict[str, object]) -> str:
    return "".join(
        f' {name.rstrip("_").replace("_", "-")}="{escape_markup(_text(value))}"'
        for name, value in attributes.items()
        if value is not None
    )


def _text(value: object) -> str:
    return number(value) if isinstance(value, float) else str(value)


def number(value: float, digits: int = 3) -> str:
    """A number with at most so many decimals, and no more than it needs."""
    text = f"{value:.{digits}f}"
    text = text.rstrip("0").rstrip(".") if "." in text else text
    return "0" if text == "-0" else text


def rows(lines: Iterable[str]) -> str:
    """Markup, one part a line."""
    return "\n".join(lines)


def hint(text: str) -> str:
    """A remark in small print; nothing for an empty text."""
    return element("p", text, class_="hint") if text else ""


def legend(sign: str, meanings: Iterable[tuple[str, str]]) -> str:
    """Explain the signs of a drawing, each by its CSS class; ``sign`` is that of all of them."""
    parts = [element("span", "", class_=f"{sign} {name}") + text for name, text in meanings]
    return element("p", " ".join(element("span", part) for part in parts), class_="legend")


def table(columns: Iterable[str], lines: Iterable[str], name: str = "scroll") -> str:
    """Make a table of rows that are markup already, in a box of this CSS class."""
    head = element("tr", "".join(element("th", column, scope="col") for column in columns))
    content = element("thead", head) + element("tbody", rows(lines))
    return element("div", element("table", content), class_=name)
