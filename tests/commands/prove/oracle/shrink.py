"""Small forms of missions that still show a defect."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator
from typing import Any

from bt_mission.base.diagnostics import InputError
from bt_mission.base.errors import BtMissionError
from bt_mission.base.yaml.dump import to_yaml
from bt_mission.sessions.load import load
from tests.commands.prove.oracle.judge import Defect, try_mission

Data = dict[str, Any]
HEADS = ("requirements", "follow", "trees", "inputs")
CHILDREN = ("do", "else", "then", "invert")
LISTS = ("sequence", "fallback", "parallel", "choose")


def smallest(
    data: Data, claim: str, faults: int, runs: int, most: int = 80
) -> tuple[str, int, Defect | None]:
    """Return a smaller mission, the bound on faults, and the defect; None where it is lost.

    Args:
        most: How many missions are tried.
    """
    defect = _shown(data, claim, faults, runs)
    while defect is not None and faults and most > 0:
        most -= 1
        less = _shown(data, claim, faults - 1, runs)
        if less is None:
            break
        faults, defect = faults - 1, less
    is_smaller = True
    while defect is not None and is_smaller and most > 0:
        is_smaller = False
        for candidate in _smaller(data):
            most -= 1
            shown = _shown(candidate, claim, faults, runs)
            if shown is not None:
                data, defect, is_smaller = candidate, shown, True
                break
            if most <= 0:
                break
    return to_yaml(data), faults, defect


def _shown(data: Data, claim: str, faults: int, runs: int) -> Defect | None:
    text = to_yaml(data)
    try:
        mission = load(text)
        return try_mission(mission, text, faults, runs, only=claim).defects.get(claim)
    except (InputError, BtMissionError):
        return None


def _smaller(data: Data) -> Iterator[Data]:
    for head in HEADS:
        part = data.get(head)
        for key in list(part) if isinstance(part, dict) else range(len(part or ())):
            changed = copy.deepcopy(data)
            del changed[head][key]
            if not changed[head]:
                del changed[head]
            yield changed
    yield from _smaller_nodes(data, lambda whole: whole, "tree")


def _smaller_nodes(data: Data, find: Callable[[Data], Any], key: Any) -> Iterator[Data]:
    """Yield missions in which the node at a key of a part is smaller."""
    node = find(data)[key]
    below = [
        (list_, index) for list_ in LISTS if list_ in node for index in range(len(node[list_]))
    ]
    children = [*below, *((name, None) for name in CHILDREN if isinstance(node.get(name), dict))]
    for name, index in children:
        changed = copy.deepcopy(data)
        child = find(changed)[key][name] if index is None else find(changed)[key][name][index]
        find(changed)[key] = child
        yield changed
    for name, index in below:
        if len(node[name]) > 1:
            changed = copy.deepcopy(data)
            del find(changed)[key][name][index]
            yield changed
    for name in list(node)[1:]:
        if name not in ("name", "do", "then"):
            changed = copy.deepcopy(data)
            del find(changed)[key][name]
            yield changed
    for name, index in children:

        def inner(whole: Data, name: str = name, index: int | None = index) -> Any:
            part = find(whole)[key]
            return part if index is None else part[name]

        yield from _smaller_nodes(data, inner, name if index is None else index)
