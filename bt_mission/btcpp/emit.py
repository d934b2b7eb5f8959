"""Elements as the text of an XML file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

WIDTH = 100
_ESCAPES = str.maketrans(
    {
        "&": "&amp;",
        "<": "&lt;",
        ">": "&gt;",
        '"': "&quot;",
        "\n": "&#10;",
        "\t": "&#9;",
        "\r": "&#13;",
    }
)


@dataclass(frozen=True)
class Tag:
    """An element to be written."""

    name: str
    attributes: Mapping[str, str] = field(default_factory=dict)
    children: tuple[Tag, ...] = ()


def xml_text(root: Tag) -> str:
    """Return an XML file with this root."""
    return "\n".join(['<?xml version="1.0" encoding="UTF-8"?>', *_lines(root, 0)]) + "\n"


def _lines(tag: Tag, indent: int) -> Iterator[str]:
    pad = " " * indent
    end = ">" if tag.children else "/>"
    said = [f'{name}="{value.translate(_ESCAPES)}"' for name, value in tag.attributes.items()]
    line = " ".join([f"{pad}<{tag.name}", *said]) + end
    if len(line) <= WIDTH or len(said) < 2:
        yield line
    else:
        yield f"{pad}<{tag.name}"
        yield from (f"{pad}    {one}" for one in said[:-1])
        yield f"{pad}    {said[-1]}{end}"
    if tag.children:
        for child in tag.children:
            yield from _lines(child, indent + 2)
        yield f"{pad}</{tag.name}>"
