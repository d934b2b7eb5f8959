"""Warnings that need no ROS."""

import pytest

from bt_mission.core.yaml.document import read_text
from bt_mission.sessions.load import load

HEAD = "mission: m\ninputs: {used: 1, idle: 2}\ntree:\n  sequence:\n"


def test_warnings_are_few_and_located():
    """No limit on a goal, and names that nobody reads."""
    mission = load(
        read_text(
            HEAD + "    - turn: {angle: $used}\n      outputs: {angle_turned: turned}\n"
            "    - explore_forward: {}\n      timeout: 9\n      outputs: {closest_obstacle: gap}\n"
            "    - log: $gap\n",
            "m.yaml",
        )
    )
    assert [str(fault).splitlines()[0] for fault in mission.warnings] == [
        "m.yaml:2:19: warning: the input 'idle' is never read [BT-231]",
        (
            "m.yaml:5:7: warning: turn has no timeout: it can run forever; "
            "add 'timeout: SECONDS' [BT-234]"
        ),
        "m.yaml:6:31: warning: the output 'turned' is never read [BT-231]",
    ]


def test_a_mission_without_oddities_has_no_warnings():
    """Silence means all is well."""
    text = HEAD.replace(", idle: 2", "") + "    - turn: {angle: $used}\n      timeout: 3\n"
    assert load(text).warnings == ()


def test_what_is_in_a_timeout_does_not_take_for_ever():
    """Whatever is between them."""
    tree = "  timeout: 9\n  do: {sequence: [{turn: {angle: 90}}, {spin: {target_yaw: 1.0}}]}\n"
    assert load(f"mission: m\ntree:\n{tree}").warnings == ()


def test_a_wait_for_a_message_without_a_limit_is_warned_of():
    """A call of a service has one of its own."""
    mission = load(
        read_text(
            "mission: m\ntree:\n  sequence:\n"
            "    - wait_for: {topic: odom, type: nav_msgs/msg/Odometry, until: x > 1}\n"
            "    - service: {name: stop, type: std_srvs/srv/Trigger}\n",
            "m.yaml",
        )
    )
    assert [str(fault).splitlines()[0] for fault in mission.warnings] == [
        (
            "m.yaml:4:7: warning: the wait for odom has no timeout: it can run forever; "
            "add 'timeout: SECONDS' [BT-234]"
        ),
    ]


def notes(tree: str) -> list[str]:
    """What is noted of a tree, a line each."""
    mission = load(read_text(f"mission: m\ninputs: {{x: 1}}\ntree:\n{tree}", "m.yaml"))
    lines = (str(fault).splitlines()[0] for fault in mission.warnings)
    return [line.partition("warning: ")[0] + line.partition("warning: ")[2] for line in lines]


@pytest.mark.parametrize(
    ("before", "never"),
    [
        ("{force: success, do: {check: x > 1}}", "fails"),
        ("{log: $x}", "fails"),
        ("{wait: 1}", "fails"),
        ("{when: x > 1, do: {wait: 1}}", "fails"),
        ("{check: true}", "fails"),
        ("{fallback: [{check: x > 1}, {wait: 1}]}", "fails"),
        ("{invert: {force: failure, do: {check: x > 1}}}", "fails"),
        ("{parallel: [{wait: 1}, {wait: $x}]}", "fails"),
        ("{choose: [{wait: 1}, {log: $x}]}", "fails"),
        ("{repeat: {count: 3}, do: {wait: $x}}", "fails"),
        ("{for_each: {y: [1]}, do: {wait: $y}}", "fails"),
        ("{force: failure, do: {check: x > 1}}", "succeeds"),
        ("{check: false}", "succeeds"),
        ("{invert: {wait: $x}}", "succeeds"),
        ("{sequence: [{wait: 1}, {check: false}]}", "succeeds"),
        ("{timeout: 9, do: {check: false}}", "succeeds"),
        ("{guard: x > 1, do: {check: false}}", "succeeds"),
    ],
)
def test_a_node_that_is_never_reached_is_warned_of(before, never):
    """Where the one before it ends its parent for certain."""
    kind = "fallback" if never == "fails" else "sequence"
    lines = notes(f"  {kind}:\n    - {before}\n    - {{log: $x}}\n    - {{wait: 1}}\n")
    place = "m.yaml:6:7: "
    text = f"{place}never reached: the node before it, in line 5, never {never} [BT-232]"
    assert [line for line in lines if "read" not in line] == [text]


@pytest.mark.parametrize(
    "before",
    [
        "{check: x > 1}",
        "{service: {name: s, type: std_srvs/srv/Trigger}}",
        "{timeout: 9, do: {wait: $x}}",
        "{guard: x > 1, do: {wait: 1}}",
        "{when: x > 1, do: {check: x > 2}}",
        "{parallel: [{wait: 1}, {check: x > 1}]}",
    ],
)
@pytest.mark.parametrize("kind", ["sequence", "fallback"])
def test_what_may_end_either_way_hides_nothing(before, kind):
    """Nothing is said where it is not certain."""
    assert notes(f"  {kind}:\n    - {before}\n    - {{log: $x}}\n") == []


def test_what_takes_time_under_a_reactive_parent_is_warned_of():
    """It begins anew in every tick, once it has ended; conditions are what stands there."""
    output = notes(
        "  sequence:\n"
        "    - check: x > 0\n"
        "    - sequence: [{wait: 1}, {wait: 2}]\n"
        "    - wait: 9\n"
        "  memory: false\n"
    )
    assert output == [
        (
            "m.yaml:6:7: once it has succeeded, this sequence restarts in every tick while a "
            "later one runs: the sequence in line 4 has 'memory: false'; put slow nodes last, or "
            "remove 'memory: false' [BT-233]"
        )
    ]


def test_variables_that_nobody_reads_are_warned_of():
    """Of `set` and `for_each`, too."""
    output = notes(
        "  sequence:\n    - set: {a: x, b: 1}\n    - for_each: {c: [1]}\n      do: {log: $a}\n"
    )
    assert output == [
        "m.yaml:5:22: the variable 'b' is never read [BT-231]",
        "m.yaml:6:21: the variable 'c' is never read [BT-231]",
    ]
