"""Every text of a mission file, as a value and as a key, in all that is made of the file."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import pytest
from PIL import ImageDraw

from bt_mission.base.diagnostics import InputError
from bt_mission.cli.main import main
from bt_mission.language.nodes.registry import KINDS
from bt_mission.requirements.schema import mission_schema
from bt_mission.sessions.check import examine
from bt_mission.views.drawing.dot import dot
from bt_mission.views.drawing.nodes import drawn, heading, outline
from bt_mission.views.drawing.scene import scene
from bt_mission.views.drawing.svg import svg
from tests.support.hostile import (
    ATTACKS,
    HOSTILE,
    MARK,
    SHORT,
    escape_nothing,
    leaks,
    markup_leaks,
)
from tests.support.hostile_mission import PRINTABLE, SOUND, yaml_of
from tests.support.thorough import sample

SCHEMA = mission_schema()
BRIEF = f"{MARK}{SHORT}\nFORGED"
TEXTS = (BRIEF, PRINTABLE, f"'{MARK}\x1b[1337m\u202e' == 1 {MARK}")
"""For texts, for names, and for expressions; short, since messages quote the beginning only."""


def holders(kind: str) -> Iterator[dict[str, Any]]:
    """A node of a kind for each of its keys, with a hostile value there, or a hostile key in it.

    The keys are those of the JSON Schema, so that a new one is tried, too.
    """
    schema = SCHEMA["$defs"][f"kind_{kind}"]
    needed = {key: example(schema["properties"][key]) for key in schema.get("required", ())}
    needed.setdefault(kind, example(schema["properties"].get(kind, {})))
    for number, key in enumerate(schema["properties"]):
        text = TEXTS[number % len(TEXTS)]
        for value in (*TEXTS, [text], {text: text}, {"name": text}):
            yield {**needed, key: value}
    yield {**needed, BRIEF: BRIEF}


def example(schema: dict[str, Any]) -> Any:
    """A value that may fit a schema."""
    if "$ref" in schema:
        return {"wait": 1}
    for choice in ("anyOf", "oneOf"):
        if choice in schema:
            return example(schema[choice][0])
    known = {"array": [{"wait": 1}], "object": {}, "integer": 2, "number": 1, "boolean": True}
    kind = schema.get("type", "")
    return schema.get("default") or known.get(kind if isinstance(kind, str) else kind[0], "1")


def heads() -> Iterator[dict[str, Any]]:
    """A mission for each key beside the tree: hostile there, and within."""
    for key in SCHEMA["properties"]:
        for text in TEXTS:
            for value in (text, [text], {text: text}, {"a": text}, {text: {"do": {"wait": 1}}}):
                yield {"mission": "m", "tree": {"wait": 1}, key: value}
    yield {"mission": "m", "tree": {"wait": 1}, BRIEF: BRIEF}


@pytest.fixture
def run(tmp_path, monkeypatch, capfdbinary) -> Any:
    """Run a command on a mission in a file of this name; gives its output and standard error."""
    monkeypatch.chdir(tmp_path)

    def command(*words: str, mission: Any = SOUND, name: str = "m.yaml") -> str:
        text = mission if isinstance(mission, str) else yaml_of(mission)
        Path(name).write_text(text, encoding="utf-8", errors="surrogatepass")
        main([*words[:1], name, *words[1:]])
        written = capfdbinary.readouterr()
        return (written.out + written.err).decode()

    return command


def said_of(mission: dict[str, Any]) -> str:
    """What `check` says of a mission, and, where it is sound, all that is made of it."""
    path = Path("m.yaml")
    path.write_text(yaml_of(mission), encoding="utf-8")
    diagnostics, faults = examine(path)
    if diagnostics is None:
        return str(InputError(faults))
    root, title = drawn(diagnostics), heading(diagnostics)
    written = [*map(str, faults), title, *map(str, outline(root)), dot(root, title)]
    written += [svg(scene(root, title))]
    return "\n".join(written)


@pytest.mark.parametrize("kind", sample(KINDS, 12))
def test_nodes(kind, tmp_path, monkeypatch):
    """What is said of each key of each kind of node; what is accepted is drawn, too."""
    monkeypatch.chdir(tmp_path)
    lines = [said_of({"mission": "m", "tree": node}) for node in holders(kind)]
    assert any(MARK in line for line in lines)
    assert leaks("\n".join(lines)) == []


def test_keys_beside_the_tree(tmp_path, monkeypatch):
    """Name, description, inputs, trees, includes, world and robot."""
    monkeypatch.chdir(tmp_path)
    lines = [said_of(mission) for mission in heads()]
    assert sum(MARK in line for line in lines) > 20
    assert leaks("\n".join(lines)) == []


@pytest.mark.parametrize("attack", ATTACKS.values(), ids=ATTACKS)
def test_lines_of_the_file_that_are_quoted(attack, run):
    """As they are written, not as they are read: the parser refuses most of them."""
    for text in (f"mission: {attack}", f"mission: m\ntree: {{wait: x{attack}}}", f"a: '{attack}"):
        shown = run("check", mission=text)
        assert "error" in shown
        assert leaks(shown) == []


def test_names_of_files(run):
    """Of missions, and of what they name: worlds, robots, included files."""
    name = HOSTILE.replace("/", "").replace("\0", "")[:180]
    assert leaks(run("check", mission={"mission": "m"}, name=f"{name}.yaml")) == []
    assert leaks(run("check", "--json", mission={"mission": "m"}, name=f"{name}.yaml")) == []
    for key in ("world", "robot"):
        shown = run("run", f"--{key}", HOSTILE.replace("\0", ""), mission=SOUND)
        assert MARK in shown
        assert leaks(shown) == []


# ---- a sound mission, in every form ----------------------------------------------------------

FORMS = {
    "text": ("tree",),
    "dot": ("tree", "--format", "dot"),
    "svg": ("tree", "--format", "svg"),
    "check": ("check",),
    "check --json": ("check", "--json"),
}


@pytest.mark.parametrize("form", FORMS)
def test_a_sound_mission(form, run):
    """As text and as a drawing; what is markup is read back as one text."""
    shown = run(*FORMS[form])
    assert leaks(shown) == []
    if form == "svg":
        assert markup_leaks(shown) == []
        ET.fromstring(shown)  # noqa: S314 - it is well-formed, whatever was in it
    if form not in ("check", "check --json"):
        assert shown.count(MARK) > 5


def test_the_picture(run, monkeypatch):
    """What is drawn as letters is escaped."""
    results: list[str] = []
    monkeypatch.setattr(ImageDraw.ImageDraw, "text", lambda *given, **_: results.append(given[2]))
    run("tree", "-o", "tree.png")
    assert any(MARK in text for text in results)
    assert leaks("".join(results)) == []


@pytest.mark.parametrize("form", [form for form in FORMS if "check" not in form])
def test_forms_can_leak(form, run, monkeypatch):
    """Where nothing is escaped, it is noticed."""
    escape_nothing(monkeypatch)
    assert leaks(run(*FORMS[form]))


def test_check_can_leak(run, monkeypatch):
    """Where nothing is escaped, it is noticed."""
    escape_nothing(monkeypatch)
    assert leaks(run("check", mission={"mission": "m", BRIEF: BRIEF}))
