"""Graphical acts as patches of text: what they change, and what they leave."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from bt_mission.base.yaml.composer import compose
from bt_mission.base.yaml.document import read_text
from bt_mission.commands.edit import patches
from bt_mission.commands.edit.plan import plan_of
from bt_mission.commands.edit.scalars import as_text
from bt_mission.commands.edit.source import Edits, PatchError, applied
from bt_mission.commands.edit.spans import Path as KeyPath
from bt_mission.commands.edit.spans import TextSpan, read_spans
from bt_mission.commands.edit.world_patches import add_thing, move_thing
from bt_mission.language.nodes.registry import KINDS
from bt_mission.requirements.mission_file import read_mission
from tests.support.project import MISSIONS, ROOT
from tests.support.thorough import sample

FLOW = """\
mission: forms      # flow and block, in one file
trees:
  look:
    needs: {angle: number}
    do:
      # a named tree
      camera_sweep: {sweep_angle: $angle, image_count: 4}
      timeout: 30
tree:
  sequence: [{wait: 1}, {log: "a, b"}, {sequence: [{wait: 2}, {wait: 3}]}]   # flow
"""
SHORT = """\
mission: short

tree:
  # the whole
  sequence:
  - wait: 1   # one second
  # before the second

  - tree: look
  - invert: {check: $far > 1}
  - finally: {timeout: 5}
    do:
      repeat:
        count: 3    # times
      do:
        turn:
          angle: 90   # deg
        timeout: 30
        # still of the turn
    then: {log: 'done: all'}
  - {turn: {angle: 5},
     timeout: 3}

inputs: {far: 2}
trees: {look: {do: {wait: 0.5}}}
"""
TEXTS = [*(path.read_text() for path in MISSIONS), FLOW, SHORT]


def _nodes(span: TextSpan, path: KeyPath = ()) -> Iterator[KeyPath]:
    if span.kind == "map" and any(key in KINDS for key in span.parts):
        yield path
    for key, part in span.parts.items():
        yield from _nodes(part, (*path, key))
    for index, part in enumerate(span.items):
        yield from _nodes(part, (*path, index))


def _below_root(text: str) -> list[KeyPath]:
    paths = [path for path in _nodes(read_spans(text)) if path and path[0] in ("tree", "trees")]
    return [path for path in paths if path[-1] not in ("inputs", "outputs")]


def _act(text: str, draw: random.Random) -> tuple[str, Callable[[], Edits]]:
    """Draw an act; return its kind, and what does it."""
    nodes = _below_root(text)
    path = draw.choice(nodes)
    slots = [path for path in nodes if isinstance(path[-1], int)] or nodes
    slot = draw.choice(slots)
    acts: dict[str, Callable[[], Edits]] = {
        "add": lambda: patches.add(text, slot, "turn: {angle: 90}\ntimeout: 30"),
        "delete": lambda: patches.delete(text, path),
        "move": lambda: patches.move(text, path, slot),
        "copy": lambda: patches.copy(text, path, slot),
        "wrap": lambda: patches.wrap(text, path, "retry", "{attempts: 3}"),
        "wrap in sequence": lambda: patches.wrap(text, path, "sequence", ""),
        "unwrap": lambda: patches.unwrap(text, path),
        "rename": lambda: patches.rename(text, path, draw.choice(["go", "a: b", "7", "", "#x"])),
        "set": lambda: patches.set_field(text, path, ("timeout",), "12.5"),
    }
    kind = draw.choice(list(acts))
    return kind, acts[kind]


def _lines(text: str) -> Counter[str]:
    """Count the lines of a text without indentation, dashes, empty lists and blank lines."""
    lines = (line.strip().removeprefix("- ").removesuffix(" []") for line in text.splitlines())
    return Counter(filter(None, lines))


def _is_about_the_node(
    kind: str, before: Counter[str], now: Counter[str], *, is_shipped: bool
) -> bool:
    """Tell whether an act changed no line but those that it is about.

    In the shipped missions every key has a line of its own.
    """
    removed, added = (before - now).total(), (now - before).total()
    match kind:
        case "add":
            return (removed, added) in ((0, 2), (1, 1))
        case "rename" | "set":
            return max(removed, added) <= 1
        case "move":
            return now == before or not is_shipped
        case "delete":
            return not added or not is_shipped
        case "copy":
            return before <= now or not is_shipped
    return True


@pytest.mark.thorough
def test_500_acts_change_the_lines_meant() -> None:
    """Each patch is small, keeps every comment that stays, and has its edits in order."""
    draw = random.Random(17)
    done: Counter[str] = Counter()
    refused = 0
    while done.total() < 500:
        text = draw.choice(TEXTS)
        is_shipped = text not in (FLOW, SHORT)
        for _ in range(10):
            if not _below_root(text):
                break
            kind, act = _act(text, draw)
            try:
                edits = act()
            except PatchError:
                refused += 1
                continue
            places = [0, *(at for edit in edits for at in (edit.start, edit.end)), len(text)]
            assert places == sorted(places)
            after, context = applied(text, edits), (kind, _lines(text))
            assert _is_about_the_node(*context, _lines(after), is_shipped=is_shipped), (text, after)
            text = after
            done[kind] += 1
    assert min(done.values()) >= 10, done
    assert refused < 200, (refused, done)


@pytest.mark.parametrize(
    ("slot", "items"),
    [(1, "[{wait: 1}, {log: b}, {wait: 2}]"), (2, "[{wait: 1}, {wait: 2}, {log: b}]")],
)
def test_a_node_is_added_between_brackets_at_its_place(slot: int, items: str) -> None:
    """Before another item, or behind the last one."""
    text = "tree:\n  sequence: [{wait: 1}, {wait: 2}]\n"
    after = applied(text, patches.add(text, ("tree", "sequence", slot), "log: b"))
    assert after == f"tree:\n  sequence: {items}\n"


ANCHORS = """\
mission: m
tree:
  sequence:
    - {turn: {angle: &a 90}, timeout: 3}
    - {turn: {angle: &a 10}, timeout: 3}
    - {turn: {angle: *a}, timeout: 3}
    - {turn: {angle: 20}, timeout: 3}
    - {turn: {angle: *a}, timeout: 3}
"""
NODES = ("tree", "sequence")


@pytest.mark.parametrize(
    "act",
    [
        lambda text: patches.delete(text, (*NODES, 1)),
        lambda text: patches.move(text, (*NODES, 1), (*NODES, 4)),
        lambda text: patches.move(text, (*NODES, 0), (*NODES, 2)),
        lambda text: patches.move(text, (*NODES, 2), (*NODES, 1)),
        lambda text: patches.copy(text, (*NODES, 0), (*NODES, 3)),
        lambda text: patches.set_field(text, (*NODES, 1), ("turn", "angle"), "11"),
        lambda text: patches.set_field(text, (*NODES, 1), ("turn",), None),
        lambda text: patches.delete(text.replace("&a 90", "90"), (*NODES, 1)),
    ],
)
def test_an_act_that_changes_another_node_by_an_alias_is_refused(
    act: Callable[[str], Edits],
) -> None:
    """An alias means the last definition of its anchor, which is the same afterwards."""
    with pytest.raises(PatchError):
        act(ANCHORS)


@pytest.mark.parametrize(
    "act",
    [
        lambda: patches.delete(SHORT, ()),
        lambda: patches.copy(SHORT, ()),
        lambda: patches.wrap(SHORT, (), "invert", ""),
        lambda: patches.unwrap(SHORT, ()),
        lambda: patches.move(SHORT, ("tree", "sequence", 0), ()),
        lambda: patches.add(SHORT, (), "wait: 1"),
        lambda: patches.set_field(SHORT, (), (), "1"),
        lambda: patches.set_field(SHORT, (), (), None),
        lambda: add_thing("half a w", "boxes", (0, 0), (1, 1)),
        lambda: add_thing("boxes: 3\n", "boxes", (0, 0), (1, 1)),
        lambda: move_thing("boxes: 3\n", ("boxes", 0), (0, 1)),
        lambda: move_thing("[1]\n", ("boxes",), (0, 1)),
        lambda: move_thing("[{x: 1}]\n", (10**30,), (0, 1)),
        lambda: move_thing("boxes: [{x: one}]\n", ("boxes", 0), (0, 1)),
        lambda: move_thing("walls: [{from: [1], to: 2}]\n", ("walls", 0), (0, 1)),
    ],
)
def test_an_act_without_a_place_in_the_text_is_refused(act: Callable[[], Edits]) -> None:
    """Such as one for the text before its last change."""
    with pytest.raises(PatchError):
        act()


def test_a_thing_gets_a_free_name_whatever_others_have() -> None:
    """Also beside one whose name is no text."""
    text = "boxes:\n  - {name: [1]}\n  - {name: box 1}\n"
    assert "name: box 2" in applied(text, add_thing(text, "boxes", (0, 0), (1, 1)))


def test_acts_beside_an_alias_are_allowed() -> None:
    """Where every alias means the same afterwards, also if a moved node holds it."""
    edits = patches.delete(ANCHORS, (*NODES, 0))
    first = "    - {turn: {angle: &a 90}, timeout: 3}\n"
    assert applied(ANCHORS, edits) == ANCHORS.replace(first, "")
    edits = patches.move(ANCHORS, (*NODES, 4), (*NODES, 3))
    lines = ANCHORS.splitlines(keepends=True)
    lines[6:8] = reversed(lines[6:8])
    assert applied(ANCHORS, edits) == "".join(lines)


@pytest.mark.parametrize("path", sample(MISSIONS, 4), ids=lambda path: path.stem)
def test_a_valid_act_on_a_shipped_mission_gives_a_valid_mission(path: Path) -> None:
    """Every node may be wrapped, and unwrapped again: the text is the same as before."""
    text = path.read_text()
    for node in _below_root(text):
        wrapped = applied(text, patches.wrap(text, node, "retry", "{attempts: 3}"))
        mission, diagnostics = read_mission(read_text(wrapped, str(path)))
        assert mission is not None, diagnostics
        assert applied(wrapped, patches.unwrap(wrapped, node)) == text


@pytest.mark.parametrize("path", sample(sorted((ROOT / "worlds").glob("*.yaml")), 4))
def test_acts_on_the_map_of_a_world_change_its_lines_only(path: Path) -> None:
    """A thing is moved by its own line; a new one is one line, with its key at most two."""
    text = path.read_text()
    lines = text.splitlines()
    plan = plan_of(text, path, "world", path.parent)
    assert plan is not None
    for thing in [*plan["shapes"], *plan["zones"]][:3]:
        after = applied(text, move_thing(text, thing["path"], (0.125, -0.25))).splitlines()
        changed = [pair for pair in zip(lines, after, strict=True) if pair[0] != pair[1]]
        assert len(changed) == 1
        back = move_thing("\n".join(after), thing["path"], (-0.125, 0.25))
        assert read_text(applied("\n".join(after), back)).data == read_text(text).data
    for section in ("walls", "boxes", "cylinders", "zones", "slippery"):
        after = applied(text, add_thing(text, section, (0, 0), (1, 0.5))).splitlines()
        new = [line for line in after if line not in lines]
        assert [line for line in after if line in lines] == lines
        assert len(new) == 1 + (f"{section}:" not in lines)


@pytest.mark.parametrize("hidden", "\x85\u2028\u2029\u200b\u202e\u3164")
def test_a_text_that_is_put_in_can_be_read(hidden: str) -> None:
    """Characters that cannot be seen are quoted."""
    assert compose(f"a: {as_text(hidden)}", "a.yaml")[0] == {"a": hidden}
