"""The generated types: exact fields, codes and hashes, which are what goes over the wire."""

import importlib
import json
import re
from pathlib import Path
from typing import Any

import pytest
from example_interfaces.action import Fibonacci
from example_interfaces.srv import AddTwoInts
from rclpy.type_support import check_for_type_support
from tf2_msgs.msg import TFMessage

from action_servers.core.maneuver import ErrorCode
from action_servers.robot_io.messages import generated_type
from tests.support.project import ROOT
from tests.support.served import SERVED

PUBLISHED = [
    (Fibonacci.Goal, "int32 order"),
    (Fibonacci.Result, "sequence<int32> sequence"),
    (Fibonacci.Feedback, "sequence<int32> sequence"),
    (AddTwoInts.Request, "int64 a, int64 b"),
    (AddTwoInts.Response, "int64 sum"),
    (TFMessage, "sequence<geometry_msgs/TransformStamped> transforms"),
]
"""Fields of types of other packages, for which ours stand in."""


@pytest.mark.parametrize(
    ("message", "fields"), [pytest.param(*row, id=row[0].__name__) for row in PUBLISHED]
)
def test_fields_are_the_published_ones(message, fields):
    """Name, type and order of each field: all three are part of the type's hash."""
    assert fields_of(message) == fields


KINDS = {"float32": "float", "float64": "double", "bool": "boolean", "byte": "octet"}
FIELD = re.compile(r"^([\w/]+)(?:\[(<=)?(\d*)\])? +([a-z]\w*)(?!\w*=)", re.MULTILINE)
PARTS = {"action": ("Goal", "Result", "Feedback"), "srv": ("Request", "Response"), "msg": ("",)}
DEFINITIONS = sorted((ROOT / "interfaces").glob("*/*/*.*"))


def fields_of(message: type[Any]) -> str:
    """The fields of a generated type."""
    results = message.get_fields_and_field_types().items()
    return ", ".join(f"{kind} {name}" for name, kind in results)


def declared_in(text: str, package: str) -> str:
    """The fields of a part of a definition, as generated types name them."""
    fields = []
    for kind, is_bounded, size, name in FIELD.findall(text):
        plain = kind if "/" in kind or kind[0].islower() else f"{package}/{kind}"
        plain = KINDS.get(plain, plain)
        (array,) = re.findall(rf"^{kind}(\[.*?\])? +{name}\b", text, re.MULTILINE)
        if size and not is_bounded:
            plain = f"{plain}[{size}]"
        elif array:
            plain = f"sequence<{plain}{f', {size}' if size else ''}>"
        fields.append(f"{plain} {name}")
    return ", ".join(fields)


@pytest.mark.parametrize(
    "path", [path for path in DEFINITIONS if path.parent.name in PARTS], ids=lambda path: path.name
)
def test_generated_types_have_the_fields_of_their_definition(path):
    """Of each message, service and action, in the order of its file."""
    kind, package = path.parent.name, path.parents[1].name
    message = getattr(importlib.import_module(f"{package}.{kind}"), path.stem)
    texts = re.split(r"^---$", path.read_text(encoding="utf-8"), flags=re.MULTILINE)
    for name, text in zip(PARTS[kind], texts, strict=True):
        assert fields_of(getattr(message, name) if name else message) == declared_in(text, package)


CODES = {
    "base": {"BLOCKED", "MOTORS_OFF"},
    "scan": {"NO_SCAN"},
    "odometry": {"NO_ODOMETRY"},
    "map": {"NO_MAP"},
    "camera": {"NO_IMAGE"},
}
"""The error codes that come with what an action needs."""

OURS = [served.action for served in SERVED.values() if served.action.type.startswith("bt_mission_")]


@pytest.mark.parametrize("action", OURS, ids=lambda action: action.name)
def test_one_error_code_means_the_same_in_every_action(action):
    """The codes of the maneuvers, from 900 up, apart from Nav2's, follow from what it needs."""
    result = generated_type(action.type).Result
    shared = {code.name: int(code) for code in ErrorCode}
    codes = {name: getattr(result, name) for name in shared if hasattr(result, name)}
    assert codes.items() <= shared.items()
    needed = set().union(*(CODES[need] for need in action.needs))
    storage = {"STORAGE"} if action.name == "camera_sweep" else set()
    assert codes.keys() == {"NONE", "UNKNOWN", "STOPPED"} | needed | storage
    assert all(code == 0 or code >= 900 for code in codes.values())


@pytest.mark.parametrize("action", [*(served.type for served in SERVED.values()), Fibonacci])
def test_every_action_has_type_support(action):
    """The C libraries behind each action load: goals can be served and sent."""
    for part in (action.Goal, action.Result, action.Feedback, action.Impl.FeedbackMessage):
        check_for_type_support(part)
        assert part.__class__._TYPE_SUPPORT is not None


HASHES = dict(
    line.split()
    for line in Path(__file__).with_name("published_hashes.txt").read_text("utf-8").splitlines()
    if not line.startswith("#")
)


def built(package: str) -> Path:
    """The folder with the descriptions of a package's types."""
    prefix = Path(importlib.import_module(package).__file__ or "").parents[4]
    return prefix / "share" / package


@pytest.mark.parametrize("name", HASHES)
def test_a_type_has_the_hash_of_the_published_one(name):
    """Else Nav2 or a tool for simulators would not find our nodes."""
    package, _, path = name.partition("/")
    text = (built(package) / f"{path}.json").read_text(encoding="utf-8")
    hashes = {row["type_name"]: row["hash_string"] for row in json.loads(text)["type_hashes"]}
    assert hashes[name] == f"RIHS01_{HASHES[name]}"


def test_simulation_interfaces_has_no_other_type():
    """The package has what the published one has, and nothing else."""
    share = built("simulation_interfaces")
    names = {
        path.relative_to(share.parent).with_suffix("").as_posix()
        for kind in PARTS
        for path in (share / kind).glob("*.json")
    }
    assert names == {name for name in HASHES if name.startswith("simulation_interfaces/")}


def test_tf_message_goes_out_under_the_type_hash_of_jazzy(rig):
    """The hash that DDS announces for /tf is the one recorded in bags of a real Jazzy."""
    node = rig.node("test_types")
    node.create_publisher(TFMessage, "tf", 1)
    (info,) = node.get_publishers_info_by_topic("tf")
    assert str(info.topic_type_hash) == (
        "RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087"
    )
