"""Warnings that need no ROS."""

from bt_mission.mission import load_text

HEAD = "mission: m\ninputs: {used: 1, idle: 2}\ntree:\n  sequence:\n"


def test_warnings_are_few_and_located():
    """No limit on a goal, and names that nobody reads."""
    mission = load_text(
        HEAD + "    - turn: {angle: $used}\n      outputs: {angle_turned: turned}\n"
        "    - explore_forward: {}\n      timeout: 9\n      outputs: {closest_obstacle: gap}\n"
        "    - log: $gap\n",
        "m.yaml",
    )
    assert [str(fault).splitlines()[0] for fault in mission.warnings] == [
        "m.yaml:2:19: warning: the input 'idle' is never read",
        "m.yaml:5:7: warning: turn has no timeout: it may take for ever; add 'timeout: SECONDS'",
        "m.yaml:6:31: warning: the output 'turned' is never read",
    ]


def test_a_mission_without_oddities_has_no_warnings():
    """Silence means all is well."""
    text = HEAD.replace(", idle: 2", "") + "    - turn: {angle: $used}\n      timeout: 3\n"
    assert load_text(text).warnings == ()


def test_a_wait_for_a_message_without_a_limit_is_warned_of():
    """A call of a service has one of its own."""
    mission = load_text(
        "mission: m\ntree:\n  sequence:\n"
        "    - wait_for: {topic: odom, type: nav_msgs/msg/Odometry, until: x > 1}\n"
        "    - service: {name: stop, type: std_srvs/srv/Trigger}\n",
        "m.yaml",
    )
    assert [str(fault).splitlines()[0] for fault in mission.warnings] == [
        (
            "m.yaml:4:7: warning: the wait for odom has no timeout: it may take for ever; "
            "add 'timeout: SECONDS'"
        ),
    ]
