"""From nodes to the elements of a tree: a node becomes the element of the first row it fits."""

from __future__ import annotations

import itertools
import re
from collections.abc import Container, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from bt_mission.btcpp.attributes import OUTPUT, VALUE, given
from bt_mission.btcpp.elements import Tag
from bt_mission.btcpp.scripts import CONDITION
from bt_mission.btcpp.table import (
    REGISTERED,
    SUBTREE,
    Child,
    Children,
    Names,
    Never,
    Port,
    Ports,
    Question,
    Refusal,
    Row,
    default_of,
    leaf_row,
    rows_for,
)
from bt_mission.core.diagnostics import MOST_FAULTS, Diagnostic, quoted
from bt_mission.core.yaml.document import Document
from bt_mission.language.action_names import ACTION_NAMES
from bt_mission.language.goal_limits import DEFAULTS, GoalLimitsTable
from bt_mission.language.node_reader import NodeReader, Signature
from bt_mission.language.nodes.base import Path
from bt_mission.language.nodes.registry import KINDS

_RESERVED = REGISTERED | {"Root", "root", "Action", "Condition", "Control", "Decorator"}
"""Names that BehaviorTree.CPP refuses as the IDs of trees, besides those of the leaves."""

_ID = re.compile(r"[A-Za-z_][\w-]*")
_ABSENT = object()
_ONLY_YAML = "write its nodes one by one, or keep the mission in YAML"
_NAMED_CHILDREN = (
    "children that count, by name",
    "write 'all' or 'any', or put those that count into a parallel of their own",
)
_POLICY = "let the rest halt; or with 'rest: finish' write all and any, or any and impossible"
_TREE_INPUT = "'set' a variable to it first, and give that"


@dataclass
class _Match:
    """How a node fits a row.

    Attributes:
        attributes: Those of the element.
        below: What stands below it: the column, the part of the node, and the path to it.
        refused: What has no counterpart: where, whether that is a key, and why.
    """

    attributes: dict[str, str] = field(default_factory=dict)
    below: list[tuple[Child | Children | Question, Any, Path]] = field(default_factory=list)
    refused: list[tuple[Path, bool, Refusal]] = field(default_factory=list)

    def fits(self, part: Any, value: Any, path: Path) -> bool:
        """Take a part of a node in; return whether it is what the row has there."""
        match part:
            case Port():
                return value is _ABSENT or self._port(part, value, path)
            case Ports():
                self._entries(part, {} if value is _ABSENT else value, path, ())
            case Never():
                if value is not _ABSENT and value != part.unless:
                    self.refused.append((path, True, part.refusal))
            case Child() | Children() | Question():
                if value is not _ABSENT:
                    self.below.append((part, value, path))
                elif isinstance(part, Child) and part.absent:
                    self.below.append((part, None, path))
            case dict():
                return isinstance(value, dict) and self.fits_node(part, value, path)
            case _:
                return bool(value == part)
        return True

    def fits_node(self, node: Mapping[str, Any], data: Mapping[str, Any], path: Path) -> bool:
        """Take a mapping in; return whether each of its keys is what the row has there."""
        return all(
            self.fits(part, data.get(key, _ABSENT), (*path, key)) for key, part in node.items()
        )

    def _port(self, port: Port, value: Any, path: Path) -> bool:
        written = port.codec.write(value)
        if written is None and port.refusal is not None:
            self.refused.append((path, False, port.refusal))
        self.attributes[port.name] = written or ""
        return written is not None or port.refusal is not None

    def _entries(self, ports: Ports, values: Mapping[str, Any], path: Path, names: Names) -> None:
        for key, value in values.items():
            inner, place = (*names, key), (*path, key)
            attribute = ports.attribute(inner)
            if ports.holds == "nested" and isinstance(value, dict) and value:
                self._entries(ports, value, place, inner)
            elif isinstance(value, dict):
                refusal = "an empty message", "leave it out: it means the same"
                self.refused.append((place, False, refusal))
            elif attribute is None:
                what = f"{quoted('.'.join(inner))}: no field of a ROS type has such a name"
                self.refused.append((place, False, (what, "see 'bt-mission check'")))
            else:
                self.attributes[attribute] = ports.codec.write(value) or ""


@dataclass
class NodeWriter:
    """Writes nodes of one document as elements, and collects what XML has no counterpart for.

    `signatures` are the named trees that may be used, `limits` are those of the mission.
    """

    document: Document
    signatures: Mapping[str, Signature]
    limits: GoalLimitsTable
    faults: list[Diagnostic] = field(default_factory=list)
    _names: set[str] = field(default_factory=set)
    """Of the uses of trees so far."""

    def refuse(self, path: Path, what: str, instead: str, *, key: bool = False) -> None:
        """Note what XML has no counterpart for."""
        if len(self.faults) < MOST_FAULTS:
            message = f"{what}: XML has no counterpart"
            self.faults.append(self.document.fault(path, message, instead, key=key))

    def node(self, data: dict[str, Any], path: Path) -> Tag:
        """Return a node and all below it as an element."""
        kind = NodeReader(self.document).kind(data, path)
        assert kind is not None, "the mission was read before"
        if kind in ACTION_NAMES or kind == "action":
            action = data["action"]["name"] if kind == "action" else ACTION_NAMES[kind].action
            said = self.limits.of(action).items()
            data = {**{name: one for name, one in said if one != DEFAULTS.get(name)}, **data}
        named = {"name": data["name"]} if data.get("name") else {}
        if kind == "tree":
            return self._use(data, path, named)
        for row in rows_for(kind):
            if (match := self._matched(row, data, path)) is not None:
                for place, key, refusal in match.refused:
                    self.refuse(place, *refusal, key=key)
                attributes = {**named, **match.attributes, **row.fixed}
                return Tag(row.tag, attributes, tuple(self._below(match)))
        self._refuse_node(kind, data, path)
        for place, inner in KINDS[kind].written_children(data):
            self.node(inner, (*path, *place))
        return Tag("AlwaysSuccess")

    def _matched(self, row: Row, data: Mapping[str, Any], path: Path) -> _Match | None:
        """Return how a node fits a row; None if it does not."""
        kind, match = row.kind, _Match()
        others = [key for key in data if key not in row.node and key != "name"]
        is_usual = all(data[key] == default_of(kind, key) for key in others)
        return match if is_usual and match.fits_node(row.node, data, path) else None

    def _below(self, match: _Match) -> Iterator[Tag]:
        """Yield the elements below the one of a row."""
        order = sorted(match.below, key=lambda one: getattr(one[0], "index", 0))
        for column, part, path in order:
            match column:
                case Children():
                    yield from (self.node(one, (*path, i)) for i, one in enumerate(part))
                case Question():
                    yield _question(part)
                case Child():
                    absent = Tag(column.absent or "")
                    child = absent if part is None else self.node(part, path)
                    is_other = part is not None and child == absent
                    yield Tag("ScriptCondition", {"code": "true"}) if is_other else child

    def _use(self, data: Mapping[str, Any], path: Path, named: Mapping[str, str]) -> Tag:
        """Return the use of a named tree."""
        if (name := named.get("name")) in self._names:
            hint = "give one of them another name: BehaviorTree.CPP refuses two of one name"
            what = f"two uses of trees with the name {quoted(name or '')}"
            self.refuse((*path, "name"), what, hint)
        elif name:
            self._names.add(name)
        use = data["tree"] if isinstance(data["tree"], dict) else {"name": data["tree"]}
        attributes = {**named, "ID": tree_id(use["name"], self.signatures)}
        types = self.signatures[use["name"]].types
        for key, value in use.get("inputs", {}).items():
            written = given(types[key] or "list").write(value)
            if written is None:
                place = (*path, "tree", "inputs", key)
                self.refuse(place, f"what '{key}' is given", _TREE_INPUT)
            attributes[key] = written or ""
        outputs = data.get("outputs", {})
        attributes |= {key: OUTPUT.write(variable) or "" for key, variable in outputs.items()}
        return Tag(SUBTREE, attributes)

    def _refuse_node(self, kind: str, data: Mapping[str, Any], path: Path) -> None:
        """Refuse a node that fits no row."""
        if kind != "parallel":
            self.refuse((*path, kind), f"'{kind}'", _ONLY_YAML, key=True)
        elif isinstance(data.get("succeed_when"), list):
            self.refuse((*path, "succeed_when"), *_NAMED_CHILDREN)
        else:
            keys = ("succeed_when", "fail_when", "rest")
            said = [f"'{key}: {data.get(key, default_of(kind, key))}'" for key in keys]
            what = f"{', '.join(said[:-1])} and {said[-1]} together"
            self.refuse((*path, "rest"), what, _POLICY, key=True)


def _question(condition: Any) -> Tag:
    """Return a condition as an element that asks it."""
    code = CONDITION.write(condition)
    if code is not None:
        return Tag("ScriptCondition", {"code": code})
    return Tag("check", {"condition": VALUE.write(condition) or ""})


def tree_id(name: str, names: Container[str]) -> str:
    """Return the ID of the tree with this name, one of `names`."""
    if _is_free(name):
        return name
    candidates = (f"{name}_tree{number or ''}" for number in itertools.count())
    return next(one for one in candidates if _is_free(one) and one not in names)


def main_id(mission: str, taken: Container[str]) -> str:
    """Return the ID of the main tree: the mission's name where it can be one."""
    own = [mission] if _ID.fullmatch(mission) and _is_free(mission) else []
    others = (f"MainTree{number}" for number in itertools.count(2))
    candidates = itertools.chain(own, ["MainTree"], others)
    return next(one for one in candidates if one not in taken and _is_free(one))


def _is_free(name: str) -> bool:
    return name not in _RESERVED and leaf_row(name) is None
