"""What BehaviorTree.CPP 4.10 checks before it makes a tree of a file, as far as ours go."""

import re
from collections.abc import Iterator
from xml.etree import ElementTree as ET

ANY = (1, None)
CHILDREN = {
    **dict.fromkeys(("AlwaysFailure", "AlwaysSuccess", "Script", "ScriptCondition"), (0, 0)),
    **dict.fromkeys(("Sleep", "SetBlackboard", "UnsetBlackboard", "SubTree"), (0, 0)),
    **dict.fromkeys(("Sequence", "SequenceWithMemory", "AsyncSequence"), ANY),
    **dict.fromkeys(("Fallback", "AsyncFallback", "ReactiveSequence", "ReactiveFallback"), ANY),
    **dict.fromkeys(("Parallel", "ParallelAll"), ANY),
    **dict.fromkeys(("IfThenElse", "WhileDoElse"), (2, 3)),
    **dict.fromkeys(("Delay", "ForceFailure", "ForceSuccess", "Inverter", "Repeat"), (1, 1)),
    **dict.fromkeys(("KeepRunningUntilFailure", "Precondition", "RunOnce", "Timeout"), (1, 1)),
    **dict.fromkeys(("RetryUntilSuccessful", "LoopBool", "LoopDouble", "LoopInt"), (1, 1)),
    **dict.fromkeys(("LoopString", "SkipUnlessUpdated", "WaitValueUpdate"), (1, 1)),
    "WasEntryUpdated": (0, 0),
    "TryCatch": (2, None),
    **{f"Switch{count}": (count + 1, count + 1) for count in range(2, 7)},
}
"""The nodes that are registered from the beginning: how many children each may have."""

PORTS = {
    "Delay": {"delay_msec"},
    "Parallel": {"success_count", "failure_count"},
    "ParallelAll": {"max_failures"},
    "Precondition": {"if", "else"},
    "Repeat": {"num_cycles"},
    "RetryUntilSuccessful": {"num_attempts"},
    "Script": {"code"},
    "ScriptCondition": {"code"},
    "Sleep": {"msec"},
    "Timeout": {"msec"},
}
"""The ports of those that have some, where a mission can be written with them."""


def _root(xml: str) -> ET.Element:
    return ET.fromstring(xml)  # noqa: S314 - what the product has written


def models(xml: str) -> dict[str, set[str]]:
    """Return the ports of the leaves that a file has models of."""
    return {
        model.attrib["ID"]: {port.attrib["name"] for port in model}
        for model in _root(xml).iterfind("TreeNodesModel/*")
        if model.tag in ("Action", "Condition")
    }


def refusals(xml: str, leaves: dict[str, set[str]]) -> Iterator[str]:
    """Yield why the file is refused where these leaves are registered with these ports."""
    root = _root(xml)
    registered = {*CHILDREN, *leaves}
    trees = [tree.get("ID", "") for tree in root.iterfind("BehaviorTree")]
    if root.get("main_tree_to_execute") not in trees:
        yield f"no main tree is among {trees}"
    if len(set(trees)) != len(trees):
        yield f"two trees of {trees} have one ID"
    for name in trees:
        if name in registered or name in ("", "Root", "root"):
            yield f"the ID '{name}' of a tree is that of a registered node"
    for tree in root.iterfind("BehaviorTree"):
        if len(tree) != 1:
            yield f"{len(tree)} children in the tree {tree.get('ID')}"
        for node in tree.iterfind(".//*"):
            yield from _refused(node, leaves, trees)


def _refused(node: ET.Element, leaves: dict[str, set[str]], trees: list[str]) -> Iterator[str]:
    ports = {name for name in node.attrib if name not in ("ID", "name") and name[0] != "_"}
    if node.tag == "SubTree":
        if node.get("ID") not in trees:
            yield f"unknown tree {node.get('ID')}"
        ports = set()
    elif "ID" in node.attrib:
        yield f"an ID in <{node.tag}>"
    if node.tag not in CHILDREN and node.tag not in leaves:
        yield f"the node {node.tag} is not registered"
        return
    least, most = CHILDREN.get(node.tag, (0, 0))
    if len(node) < least or (most is not None and len(node) > most):
        yield f"{len(node)} children in <{node.tag}>"
    unknown = ports - (leaves[node.tag] if node.tag in leaves else PORTS.get(node.tag, set()))
    if unknown:
        yield f"no ports {sorted(unknown)} of <{node.tag}>"


WRITTEN = {
    "double": re.compile(r"[-+]?(\d+(\.\d*)?|\.\d+)(e[-+]?\d+)?", re.IGNORECASE),
    "int": re.compile(r"[-+]?\d+"),
    "bool": re.compile("true|false|0|1"),
}
"""The types whose constants are converted when a tree is made, and what they look like."""


def type_refusals(xml: str) -> Iterator[str]:
    """Yield the constants that their port's type refuses, and the inputs of another type."""
    root = _root(xml)
    types = {
        (model.attrib["ID"], port.attrib["name"]): port.get("type", "")
        for model in root.iterfind("TreeNodesModel/*")
        for port in model
        if "name" in port.attrib
    }
    main = root.get("main_tree_to_execute", "")
    for node in root.iterfind("BehaviorTree//*"):
        for name, value in node.attrib.items():
            wanted = types.get((node.tag, name), "")
            if value.startswith("{") and value.endswith("}"):
                given = types.get((main, value[1:-1]), wanted)
                if node.tag != "SubTree" and wanted in WRITTEN and given != wanted:
                    yield f"{value} is a port of the type {given}, and {node.tag} reads a {wanted}"
            elif wanted in WRITTEN and not WRITTEN[wanted].fullmatch(value):
                yield f"{name}={value!r} of {node.tag} is no {wanted}"
