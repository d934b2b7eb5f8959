"""The types of snapshots: those of py_trees_ros_interfaces, hashes and codes."""

import json
from pathlib import Path

import py_trees_ros_interfaces
import pytest
from py_trees_ros_interfaces.msg import Behaviour


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        # What the files of py_trees_ros_interfaces 2.1.0 give.
        (
            "msg/BehaviourTree",
            "RIHS01_fbea5f031e37fdce7feb9f63dd16665db8d2a8f4150d907bd4b5c1f93ed49afa",
        ),
        (
            "srv/OpenSnapshotStream",
            "RIHS01_a71be77009b7eebdc8b48a84dc07bf7c14b6973be2a42d27944de754bb8896ee",
        ),
        (
            "srv/CloseSnapshotStream",
            "RIHS01_d7dc6548b32f8d97f0b67ab25751121fe74e82dbd08ce907004363d282132aea",
        ),
        (
            "srv/ReconfigureSnapshotStream",
            "RIHS01_57f08c76262c940ca6db136a782d73c88781437f2a31928b7443c262d9845fbe",
        ),
    ],
)
def test_snapshots_have_the_type_hash_of_py_trees_ros(name, expected):
    """Its tree watcher takes our snapshots for its own."""
    prefix = Path(py_trees_ros_interfaces.__file__).parents[4]
    path = prefix / f"share/py_trees_ros_interfaces/{name}.json"
    rows = json.loads(path.read_text(encoding="utf-8"))["type_hashes"]
    hashes = {row["type_name"]: row["hash_string"] for row in rows}
    assert hashes[f"py_trees_ros_interfaces/{name}"] == expected


def test_snapshots_have_the_codes_of_py_trees_ros():
    """Statuses and types are numbers there; the words of access are strings."""
    statuses = ("INVALID", "RUNNING", "SUCCESS", "FAILURE")
    assert [getattr(Behaviour, name) for name in statuses] == [1, 2, 3, 4]
    types = ("UNKNOWN_TYPE", "BEHAVIOUR", "SEQUENCE", "SELECTOR", "PARALLEL", "CHOOSER")
    assert [getattr(Behaviour, name) for name in (*types, "DECORATOR")] == [*range(7)]
    levels = ("DETAIL", "COMPONENT", "BIG_PICTURE", "NOT_A_BLACKBOX")
    assert [getattr(Behaviour, f"BLACKBOX_LEVEL_{name}") for name in levels] == [1, 2, 3, 4]
    access = ("READ", "WRITE", "EXCLUSIVE_WRITE")
    assert [getattr(Behaviour, f"BLACKBOARD_ACCESS_{name}") for name in access] == ["r", "w", "x"]
