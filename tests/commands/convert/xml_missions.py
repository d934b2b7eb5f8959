"""Missions in the XML of Groot 2, mutated as elements, attributes and characters."""

from __future__ import annotations

import re
from copy import deepcopy
from pathlib import Path
from random import Random
from xml.etree import ElementTree as ET

from bt_mission.base.diagnostics import InputError
from bt_mission.base.yaml.document import read
from bt_mission.commands.convert.mission_writer import mission_xml
from tests.support.fuzz.cases import edited
from tests.support.fuzz.expressions import expression

_NAMES = ("x", "step", "going", "word", "millis", "turned")
_VALUES = ("", "0", "-1", "1e999", "9" * 400, "true", "{x}", "{", "$x", "x; y", "'", "a := 1", "前")
_SPAN = re.compile(r'"[^"]*"|[A-Za-z_]+')
_WORDS = "< > / = \" ' & &amp; &#0; &#10; <!-- --> <![CDATA[ ]]> <?pi?> <a/> </a> { } := ; $x é"
_PIECES = (
    *_WORDS.split(),
    *("<!DOCTYPE x>", '<!DOCTYPE x [<!ENTITY y "z">]>', "&y;", "<a>" * 300, "9" * 400),
    *("\x00", "\ufffe", "\u2028", "\ufeff", "\r", "\t", "\n", "<Sequence>", "</Sequence>"),
)


def texts(folders: tuple[Path, ...], whole: Path) -> tuple[str, ...]:
    """Return the missions of some folders that can be written as XML, and one that is there."""
    all_texts = [whole.read_text(encoding="utf-8")]
    for folder in folders:
        for path in sorted(folder.glob("*.yaml")):
            try:
                all_texts.append(mission_xml(read(path)))
            except InputError:  # with nodes that XML has no counterpart for
                continue
    return tuple(all_texts)


def mutated(rng: Random, text: str) -> str:
    """Return a changed file: mostly still XML, sometimes no more."""
    if rng.random() < 0.3:
        return _textual(rng, text)
    root = ET.fromstring(text)  # noqa: S314 - our own
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        _change(rng, root)
    text = ET.tostring(root, encoding="unicode")
    return _textual(rng, text) if rng.random() < 0.1 else text


def _change(rng: Random, root: ET.Element) -> None:
    parents = [element for element in root.iter() if len(element)]
    parent = rng.choice(parents)
    index = rng.randrange(len(parent))
    other = rng.choice(list(root.iter()))
    match rng.randrange(7):
        case 0:
            parent.insert(index, deepcopy(other))
        case 1:
            del parent[index]
            if not any(len(element) for element in root.iter()):
                root.append(deepcopy(other))
        case 2:
            parent[index].tag = other.tag
        case 3:
            wrapped = ET.Element(other.tag, dict(other.attrib))
            wrapped.append(parent[index])
            parent[index] = wrapped
        case _:
            _change_attribute(rng, root)


def _change_attribute(rng: Random, root: ET.Element) -> None:
    having = [element for element in root.iter() if element.attrib]
    element, other = rng.choice(having), rng.choice(having)
    key, value = rng.choice(sorted(other.attrib.items()))
    match rng.randrange(5):
        case 0:
            element.set(key, value)
        case 1:
            del element.attrib[rng.choice(sorted(element.attrib))]
        case 2:
            element.set(rng.choice(sorted(element.attrib)), value)
        case 3:
            element.set(rng.choice(sorted(element.attrib)), rng.choice(_VALUES))
        case _:
            element.set(rng.choice(sorted(element.attrib)), expression(rng, _NAMES))


def _textual(rng: Random, text: str) -> str:
    for _ in range(rng.choice((1, 1, 2, 3))):
        text = edited(rng, text, _PIECES, _SPAN)
    return text
