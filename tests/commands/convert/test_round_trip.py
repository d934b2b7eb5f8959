"""From YAML to XML and back: the mission is the same, whatever it holds."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bt_mission.base.yaml.document import read, read_text
from bt_mission.commands.convert.document import document_of
from bt_mission.commands.convert.mission_writer import mission_xml
from bt_mission.commands.convert.yaml_text import yaml_text
from bt_mission.ros.interface_types import shapes
from bt_mission.sessions.check import examine
from bt_mission.sessions.load import load
from tests.support.missions import meaning
from tests.support.project import MISSIONS, ROOT
from tests.support.thorough import sample

SHIPPED = sorted(path.relative_to(ROOT) for path in MISSIONS)


def back(xml):
    """Return the mission of an XML text, by way of YAML."""
    return load(yaml_text(document_of(xml, "m.xml").data))


@pytest.mark.parametrize("path", sample(SHIPPED, 5), ids=str)
def test_a_shipped_mission_comes_back_as_it_was(path):
    """All of them can be said in XML; what comes back passes the same check."""
    xml = mission_xml(read(ROOT / path), shapes)
    there = load(document_of(xml, "m.xml"))
    here = load(read(ROOT / path))
    assert meaning(there) == meaning(here)
    assert meaning(back(xml)) == meaning(here)
    lines = [
        [fault.message for fault in examine(document)[1]]
        for document in (document_of(xml, "m.xml"), read(ROOT / path))
    ]
    assert lines[0] == lines[1]


# ---- generated trees ---------------------------------------------------------------------

NAMES = ("n", "x", "flag", "words", "places", "seen")
HEAD = {
    "mission": "generated",
    "inputs": {"n": 3, "x": 0.5, "flag": True, "words": "a 'b' <c>", "places": [[1, 2.0], "z"]},
}
TREES = {
    "visit": {
        "description": 'One & other\n"place"',
        "needs": {"place": "list", "who": "text"},
        "inputs": {"times": 2, "speed": 1.0, "quiet": False},
        "outputs": {"seen": "number"},
        "do": {"set": {"seen": "speed * times"}},
    }
}
TEXTS = st.text(st.characters(exclude_categories=["Cs"], exclude_characters="$"), max_size=12)
LINES = TEXTS.filter(lambda text: text and text.isprintable())
NUMBERS = st.one_of(
    st.integers(-(2**40), 2**40), st.floats(allow_nan=False, allow_infinity=False, width=32)
)
SECONDS = st.one_of(
    st.integers(1, 10**6),
    st.integers(1, 10**7).map(lambda ms: ms / 1000),
    st.sampled_from(["$x", "$n / 1000", "x * 2", "uniform(1, 2)"]),
)
LIMITS = st.one_of(st.integers(1, 900), st.sampled_from([0.25, "$x", "60 / x", "n"]))
FLAGS = st.sampled_from(
    [
        "flag",
        "not flag",
        "not  flag",
        "x > 1 and not (n < 2)",
        "x > 1 or n == 2 and flag",
        "$flag",
        "words == 'a' or x != 2.5e3",
        "true",
        "-x <= - n",
        "x ** 2 > 1",
        "0 < x < 1",
        "len(places) > 0",
        'words == "a"',
        True,
        False,
    ]
)
VALUES = st.one_of(
    NUMBERS,
    st.booleans(),
    st.sampled_from(["$x", "x + 1", "'it'", "0", "true", "-1", "x*2", "words", "places"]),
    st.lists(st.one_of(NUMBERS, TEXTS), max_size=3),
)
PLAIN = st.recursive(
    st.one_of(
        NUMBERS, st.booleans(), TEXTS, st.sampled_from(["$x", "$", "{x}", '"q"', "[1", "$x 1"])
    ),
    lambda inner: st.one_of(
        st.lists(inner, max_size=3),
        st.dictionaries(st.sampled_from(["a", "b_c", "name", "x2"]), inner, min_size=1, max_size=3),
    ),
    max_leaves=4,
)
FIELDS = st.dictionaries(
    st.sampled_from(["angle", "timeout", "name", "goal", "out_a", "target", "type"]),
    PLAIN,
    max_size=3,
)
OUTPUTS = st.dictionaries(
    st.sampled_from(["angle", "pose.position.x", "a_b"]),
    st.sampled_from(["seen", "other"]),
    max_size=2,
)


def node(fields, **optional):
    """Return nodes of these fields; others may be there as well."""
    return st.fixed_dictionaries(fields, optional=optional)


def interface(optional="", /, **fields):
    """Return the names of a server or topic, and perhaps the fields that it gets."""
    names = {name: st.just(value) for name, value in fields.items()}
    return st.fixed_dictionaries(names, optional={optional: FIELDS} if optional else {})


LIMITED = {"timeout": LIMITS, "outputs": OUTPUTS}
GOAL = LIMITED | {
    "cancel_when": st.sampled_from(["angle > 1", "$flag", "a.b < $x and true"]),
    "on_cancel": st.sampled_from(["success", "failure"]),
    "server_timeout": st.integers(1, 9),
    "feedback_timeout": LIMITS,
    "name": LINES,
}
VISIT = {
    "place": st.lists(NUMBERS, max_size=2) | st.just("$places"),
    "who": st.sampled_from(["$words", "'Ann'", '"it\'s"', "'[1]'"]),
}
MORE = {
    "times": st.integers(0, 9) | st.just("$n"),
    "speed": st.floats(-9, 9) | st.just("$x"),
    "quiet": st.booleans() | st.just("$flag"),
}
USE = node({"name": st.just("visit"), "inputs": node(VISIT, **MORE)})
PYTHON_INPUTS = st.dictionaries(st.sampled_from(["a__b", "x"]), VALUES)
LOGS = TEXTS | st.sampled_from(["$x", "at ${x + 1} m", "$$", "{x}", "90"])
SETS = st.dictionaries(st.sampled_from(["seen", "a", "name"]), VALUES, min_size=1)
LEAVES = st.one_of(
    node({"turn": FIELDS}, **GOAL),
    node({"action": interface("goal", name="/a/b", type="p/action/T")}, **GOAL),
    node({"service": interface("request", name="s", type="p/srv/T")}, **LIMITED),
    node({"publish": interface("message", topic="~/t", type="p/msg/T")}, name=LINES),
    node({"wait_for": interface(topic="t", type="p/msg/T", until="$x < data")}, **LIMITED),
    node({"log": LOGS}, name=LINES),
    node({"wait": SECONDS}, name=LINES),
    node({"check": FLAGS}, name=LINES),
    node({"set": SETS}, name=LINES),
    node({"tree": USE}, name=LINES),
    node({"python": st.just("m:C")}, inputs=PYTHON_INPUTS),
)
POLICIES = st.sampled_from(
    [
        {},
        {"succeed_when": "any"},
        {"succeed_when": "any", "fail_when": "impossible"},
        {"succeed_when": "all", "fail_when": "impossible"},
        {"succeed_when": "any", "fail_when": "impossible", "rest": "finish"},
        {"rest": "finish"},
    ]
)


def above(nodes):
    """Return nodes above others."""
    many = st.lists(nodes, min_size=1, max_size=3)
    times = st.integers(1, 99) | st.just("$n")
    seconds = st.integers(1, 10**6).map(lambda ms: ms / 1000)
    ends = st.sampled_from(["success", "failure"])
    return st.one_of(
        node({"sequence": many}, memory=st.booleans(), name=LINES),
        node({"fallback": many}, memory=st.booleans(), name=LINES),
        st.tuples(many, POLICIES).map(lambda both: {"parallel": both[0], **both[1]}),
        node({"repeat": node({"count": times}), "do": nodes}, name=LINES),
        node({"retry": node({"attempts": times}), "do": nodes}, name=LINES),
        node({"timeout": seconds, "do": nodes}, name=LINES),
        node({"invert": nodes}, name=LINES),
        node({"force": ends, "do": nodes}, name=LINES),
        node({"guard": FLAGS, "do": nodes}, name=LINES),
        node({"when": FLAGS, "do": nodes}, **{"else": nodes, "name": LINES}),
    )


def unname(part, names):
    """Take the name from a use of a tree that another has: BehaviorTree.CPP refuses two."""
    if isinstance(part, dict):
        if "tree" in part and part.get("name") in names:
            del part["name"]
        elif "tree" in part and "name" in part:
            names.add(part["name"])
    for child in (
        part.values() if isinstance(part, dict) else part if isinstance(part, list) else ()
    ):
        unname(child, names)


NODES = st.recursive(LEAVES, above, max_leaves=8)


@settings(max_examples=150)
@given(NODES)
def test_a_generated_mission_comes_back_as_it_was(tree):
    """Its YAML says what its data are, and its XML says the same."""
    unname(tree, set())
    data = {**HEAD, "trees": TREES, "tree": {"sequence": [{"set": {"seen": 0, "other": 0}}, tree]}}
    document = read_text(yaml_text(data), "m.yaml")
    assert document.data == data
    xml = mission_xml(document)
    here = load(document)
    assert meaning(back(xml)) == meaning(here)
