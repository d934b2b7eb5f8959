"""Changes to a mission as data: keys, nodes and values are moved, lost, doubled and spoilt."""

from __future__ import annotations

import copy
import math
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from random import Random
from typing import Any

from bt_mission.language.nodes.registry import KINDS
from tests.support.fuzz.expressions import HOSTILE, expression

RAW = "@RAW@{}@"
"""A text in data that stands in the file without quotes."""

SCALARS = (
    *(0, 1, -1, 2, 2**31, 2**31 - 1, 2**32, 2**53, 2**63, 2**64, 2**64 + 1, 10**30, -(2**63)),
    *(0.0, -0.0, 0.5, 2.0, 1e9, 1e10, 1e18, 1e19, 1e300, 1e308, -1e308, 5e-324, 1e-300),
    *(math.nan, math.inf, -math.inf, True, False, None, "", " ", "$", "$$", "${", "true", "1"),
    *("é", "前", "😀", "\u202e", "\x1b[2J", "\x07", "\u2028", "a" * 300, "a" * 3000, "x/y", "/"),
    *("../../../etc/passwd", "/dev/zero", "loop.yaml", "folder.yaml", "m.yaml", "parts.yaml"),
    *("os:system", "own_leaves.py:Countdown", "own_leaves.py:nobody", "waffle", "burger"),
    *("std_msgs/msg/String", "geometry_msgs/msg/PoseStamped", "std_srvs/srv/SetBool"),
    *("number", "integer", "bool", "text", "list", "all", "any", "impossible", "finish"),
    *(
        RAW.format(text)
        for text in (
            *(".nan", ".inf", "-.inf", "1e999", "9" * 300, "0x7f", "0o17", "1_000", "=", "<<", "~"),
            *("!!str 5", "!!python/object/apply:os.system [x]", "!x y", "&a 1", "*a", "*id001"),
            *("&a [*a]", "[[[[", "{{", "- - -", "? a", "|", ">-", '"\\x07"', '"\\ud83d"', "'", "%"),
        )
    ),
)
"""Values that somebody would rather not be given."""

CONTAINERS: tuple[Callable[[Random, Any], Any], ...] = (
    lambda _rng, node: {"sequence": [node]},
    lambda rng, node: {"fallback": [node, {"log": "plan B"}], "memory": rng.random() < 0.7},
    lambda rng, node: {
        "parallel": [node, {"wait": 1}],
        "succeed_when": rng.choice(("all", "any")),
        "fail_when": rng.choice(("any", "impossible")),
        "rest": rng.choice(("halt", "finish")),
    },
    lambda rng, node: {"choose": [node, {"log": "or not"}], "weights": [rng.choice((1, 1e308)), 1]},
    lambda rng, node: {"repeat": {"count": rng.randint(1, 3)}, "do": node},
    lambda rng, node: {"repeat": {"until": rng.random() < 0.5, "count": 2}, "do": node},
    lambda rng, node: {"repeat": {"while": rng.random() < 0.5}, "do": node},
    lambda rng, node: {"retry": {"attempts": 2, "pause": rng.choice((0, 1, 1e10))}, "do": node},
    lambda rng, node: {"timeout": rng.choice((0.1, 5, 1e10, 1e300)), "do": node},
    lambda _rng, node: {"invert": node},
    lambda rng, node: {"force": rng.choice(("success", "failure")), "do": node},
    lambda _rng, node: {"guard": True, "do": node},
    lambda rng, node: {"finally": {"timeout": rng.choice((1, 9))}, "do": node, "then": {"wait": 1}},
    lambda _rng, node: {"finally": {"timeout": 9}, "do": {"wait": 1}, "then": node},
    lambda rng, node: {"when": rng.choice((True, False)), "do": node, "else": {"log": "no"}},
    lambda rng, node: {"for_each": {rng.choice("pqr"): [1, "a", [2, 3]]}, "do": node},
)


@dataclass(frozen=True)
class Pool:
    """What the corpus has to offer: nodes, keys and values."""

    nodes: tuple[Any, ...]
    keys: tuple[str, ...]
    names: frozenset[str]
    values: tuple[Any, ...]


@dataclass(frozen=True)
class Slot:
    """One place in the data: a key of a mapping or an index of a list."""

    holder: Any
    key: Any

    @property
    def value(self) -> Any:
        return self.holder[self.key]

    def put(self, value: Any) -> None:
        self.holder[self.key] = value


def slots(data: Any) -> list[Slot]:
    """Return every place in the data, each once though aliases lead there."""
    places: list[Slot] = []
    waiting, seen = [data], {id(data)}
    while waiting:
        holder = waiting.pop()
        for key in holder if isinstance(holder, dict) else range(len(holder)):
            places.append(Slot(holder, key))
            value = holder[key]
            if isinstance(value, dict | list) and id(value) not in seen:
                seen.add(id(value))
                waiting.append(value)
    return places


def is_node(value: Any) -> bool:
    """Return whether that looks like a node of a mission."""
    return isinstance(value, dict) and any(key in KINDS for key in value)


def names_in(data: Any) -> tuple[str, ...]:
    """Return the variables of a mission."""
    return tuple(_names(data))


def _names(data: Any) -> Iterator[str]:
    for slot in slots(data):
        if slot.key in ("inputs", "set", "for_each", "needs") and isinstance(slot.value, dict):
            yield from (key for key in slot.value if isinstance(key, str))
        elif slot.key == "outputs" and isinstance(slot.value, dict):
            yield from (name for name in slot.value.values() if isinstance(name, str))


def change(rng: Random, data: Any, pool: Pool, *, gently: bool = False) -> None:
    """Change the data in one place; gently means that a sound mission may stay one."""
    places = slots(data)
    if places:
        changes = _GENTLE if gently else _ANY
        rng.choices(tuple(changes), tuple(changes.values()))[0](rng, data, places, pool)


def supply(rng: Random, data: Any, pool: Pool) -> None:
    """Give what is read and never written a value, as an input."""
    known = names_in(data)
    texts = [slot.value for slot in slots(data) if isinstance(slot.value, str)]
    read = _READ.findall(" ".join(texts))
    wanted = [name for name in dict.fromkeys(read) if name in pool.names and name not in known]
    if wanted and isinstance(data.get("inputs", {}), dict):
        values = {name: copy.deepcopy(rng.choice(INPUTS)) for name in wanted}
        data["inputs"] = {**data.get("inputs", {}), **values}
    data.setdefault("include", ["parts.yaml"])


_READ = re.compile(r"[A-Za-z_]\w*")
INPUTS: tuple[Any, ...] = (
    *(0, 1, 2, 3.5, -1, 0.25, 90, True, False, "a"),
    *([1, 2, 3], [0.5, 1, 90], [[1, 2, 3]], []),
)


def _spoil(rng: Random, _data: Any, places: list[Slot], _pool: Pool) -> None:
    leaves = [slot for slot in places if not isinstance(slot.value, dict | list)] or places
    rng.choice(leaves).put(rng.choice(SCALARS))


def _replace(rng: Random, _data: Any, places: list[Slot], pool: Pool) -> None:
    rng.choice(places).put(copy.deepcopy(rng.choice(pool.values)))


def _compute(rng: Random, data: Any, places: list[Slot], _pool: Pool) -> None:
    leaves = [slot for slot in places if not isinstance(slot.value, dict | list)] or places
    names = names_in(data)
    wanted = [slot for slot in leaves if slot.key in _COMPUTED]
    slot = rng.choice(wanted if wanted and rng.random() < 0.7 else leaves)
    text = rng.choice(HOSTILE) if rng.random() < 0.1 else expression(rng, names)
    slot.put(f"now ${{{text}}}" if slot.key == "log" else text)


_COMPUTED = (
    *("guard", "when", "check", "wait", "timeout", "count", "attempts", "pause", "angle"),
    *("cancel_when", "until", "log"),
)


def _rename(rng: Random, _data: Any, places: list[Slot], pool: Pool) -> None:
    slot = rng.choice([place for place in places if isinstance(place.holder, dict)] or places)
    if isinstance(slot.holder, dict):
        new = rng.choice(pool.keys) if rng.random() < 0.8 else str(rng.choice(SCALARS))
        items = list(slot.holder.items())
        slot.holder.clear()
        slot.holder.update((new if key == slot.key else key, value) for key, value in items)


def _delete(rng: Random, _data: Any, places: list[Slot], _pool: Pool) -> None:
    slot = rng.choice(places)
    del slot.holder[slot.key]


def _double(rng: Random, _data: Any, places: list[Slot], _pool: Pool) -> None:
    slot = rng.choice([place for place in places if isinstance(place.holder, list)] or places)
    if isinstance(slot.holder, list):
        times = rng.choice((1, 1, 1, 2, 20))
        slot.holder[slot.key : slot.key] = [copy.deepcopy(slot.value) for _ in range(times)]
    else:
        slot.holder[f"{slot.key}_"] = copy.deepcopy(slot.value)


def _swap(rng: Random, _data: Any, places: list[Slot], _pool: Pool) -> None:
    mine, two = rng.choice(places), rng.choice(places)
    first, second = mine.value, two.value
    mine.put(second)
    two.put(first)


def _splice(rng: Random, _data: Any, places: list[Slot], pool: Pool) -> None:
    new = copy.deepcopy(rng.choice(pool.nodes))
    slot = rng.choice([place for place in places if is_node(place.value)] or places)
    if isinstance(slot.holder, list) and rng.random() < 0.6:
        slot.holder.insert(slot.key, new)
    else:
        slot.put(new)


def _wrap(rng: Random, _data: Any, places: list[Slot], _pool: Pool) -> None:
    slot = rng.choice([place for place in places if is_node(place.value)] or places)
    for _ in range(rng.choice((1, 1, 2, 3, 40, 120))):
        slot.put(rng.choice(CONTAINERS)(rng, slot.value))


def _unwrap(rng: Random, _data: Any, places: list[Slot], _pool: Pool) -> None:
    """Put a node in the place of one above it."""
    nodes = [place for place in places if is_node(place.value)] or places
    slot = rng.choice(nodes)
    if isinstance(slot.value, dict | list):
        inner = [place for place in slots(slot.value) if is_node(place.value)]
        if inner:
            slot.put(rng.choice(inner).value)


def _share(rng: Random, _data: Any, places: list[Slot], _pool: Pool) -> None:
    """Put one value in two places: an alias, perhaps one that contains itself."""
    source = rng.choice(
        [place for place in places if isinstance(place.value, dict | list)] or places
    )
    rng.choice(places).put(source.value)


def _modify(rng: Random, _data: Any, places: list[Slot], pool: Pool) -> None:
    """Give a node a modifier, mostly one that some kind has."""
    slot = rng.choice([place for place in places if is_node(place.value)] or places)
    if isinstance(slot.value, dict):
        slot.value[rng.choice(pool.keys)] = copy.deepcopy(rng.choice((*pool.values, *SCALARS)))


def _include(rng: Random, data: Any, _places: list[Slot], _pool: Pool) -> None:
    if isinstance(data, dict):
        files = ("parts.yaml", "ring.yaml", "loop.yaml", "folder.yaml", "m.yaml", "outside.yaml")
        data["include"] = [rng.choice(files) for _ in range(rng.randint(1, 3))]


def _shuffle(rng: Random, _data: Any, places: list[Slot], _pool: Pool) -> None:
    """Put the children of a node in another order."""
    slot = rng.choice([place for place in places if isinstance(place.value, list)] or places)
    if isinstance(slot.value, list):
        rng.shuffle(slot.value)


def _nudge(rng: Random, _data: Any, places: list[Slot], _pool: Pool) -> None:
    """Give a number another value."""
    numbers = [place for place in places if isinstance(place.value, int | float)]
    if numbers:
        rng.choice(numbers).put(rng.choice((0, 1, 2, 3, 5, -1, 0.1, 1.5, 1e6, True, "1 + 1")))


_Change = Callable[[Random, Any, list[Slot], Pool], None]
_GENTLE: dict[_Change, int] = {
    **dict.fromkeys((_compute, _splice), 6),
    **dict.fromkeys((_nudge, _unwrap), 3),
    _wrap: 4,
    _double: 2,
    _shuffle: 1,
}
_ANY: dict[_Change, int] = {
    **dict.fromkeys((_spoil, _modify, _delete, _rename, _swap, _share, _include), 1),
    **dict.fromkeys((_replace, _double, _splice, _wrap), 2),
    _compute: 4,
}
