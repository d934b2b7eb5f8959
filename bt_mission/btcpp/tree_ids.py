"""The IDs of trees: BehaviorTree.CPP refuses a tree that has the name of a registered node."""

from __future__ import annotations

import itertools
import re
from collections.abc import Container

from bt_mission.btcpp.leaves import LEAVES

TREE_NAME = "tree"
"""The attribute of `Metadata` with the name of a tree whose ID had to be another one."""

REGISTERED = frozenset(
    (
        *("AlwaysFailure", "AlwaysSuccess", "AsyncFallback", "AsyncSequence", "Delay", "Fallback"),
        *("ForceFailure", "ForceSuccess", "IfThenElse", "Inverter", "KeepRunningUntilFailure"),
        *("LoopBool", "LoopDouble", "LoopInt", "LoopString", "Parallel", "ParallelAll"),
        *("Precondition", "ReactiveFallback", "ReactiveSequence", "Repeat", "RetryUntilSuccessful"),
        *("RunOnce", "Script", "ScriptCondition", "Sequence", "SequenceWithMemory"),
        *("SetBlackboard", "SkipUnlessUpdated", "Sleep", "SubTree", "Switch2", "Switch3"),
        *("Switch4", "Switch5", "Switch6", "Timeout", "TryCatch", "UnsetBlackboard"),
        *("WaitValueUpdate", "WasEntryUpdated", "WhileDoElse"),
    )
)
"""The nodes that a factory of BehaviorTree.CPP 4 registers by itself."""

_RESERVED = REGISTERED | {"Root", "root", "Action", "Condition", "Control", "Decorator"}
_ID = re.compile(r"[A-Za-z_][\w-]*")


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
    return name not in _RESERVED and name not in LEAVES
