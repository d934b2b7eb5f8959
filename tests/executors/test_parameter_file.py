"""Facts about parameter files: each mistake has its place."""

from __future__ import annotations

import pytest

from bt_mission.core.diagnostics import InputError
from bt_mission.executors.parameter_file import read_parameters

NODE = "bt_mission_servers"


@pytest.fixture
def written(tmp_path):
    """Write a parameter file; gives its path."""

    def write(text: str):
        path = tmp_path / "robot.yaml"
        path.write_text(text, encoding="utf-8")
        return path

    return write


def test_nested_names_are_joined_by_dots(written):
    """As ROS does, from the section of any node and from our own."""
    file = read_parameters(
        written(
            "/**:\n  ros__parameters: {topics: {scan: lidar}, control_rate: 10.0}\n"
            "bt_mission_servers:\n  ros__parameters:\n    frames.base: base\n"
            "bt_mission_arbiter:\n  ros__parameters:\n    timeouts: {joy: 1.0}\n"
        ),
        NODE,
    )
    assert file.values == {"topics.scan": "lidar", "control_rate": 10.0, "frames.base": "base"}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("bt_mission_server:\n  ros__parameters: {}\n", "robot.yaml:1:1: error: no such node"),
        ("/**:\n  parameters: {a: 1}\n", "expected only 'ros__parameters:'"),
        ("/**:\n  ros__parameters: {a: [1]}\n", "robot.yaml:2:24: error: expected a value for 'a'"),
        ("[]\n", "expected '/**:' or 'bt_mission_servers:'"),
    ],
)
def test_what_is_no_parameter_file_is_refused(written, text, message):
    """With the place."""
    with pytest.raises(InputError) as caught:
        read_parameters(written(text), NODE)
    assert message in str(caught.value)


def test_a_name_that_nobody_knows_is_refused(written):
    """ROS would pass over it, and the default would hold."""
    file = read_parameters(written("/**:\n  ros__parameters:\n    topics: {scam: x}\n"), NODE)
    with pytest.raises(InputError) as caught:
        file.refuse_unknown(["topics.scan", "control_rate"])
    assert "robot.yaml:3:14: error: no such parameter 'topics.scam'" in str(caught.value)
    assert "did you mean 'topics.scan'?" in str(caught.value)
