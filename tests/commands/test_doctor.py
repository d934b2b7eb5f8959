"""`bt-mission doctor` names what is missing, and continues."""

import io

import pytest
import rclpy
from geometry_msgs.msg import Twist, TwistStamped
from rclpy.context import Context
from rclpy.node import Node
from rich.console import Console

from bt_mission.commands import doctor
from bt_mission.commands.doctor import CheckResult, DoctorCheck


def _report(*checks):
    printed = io.StringIO()
    code = doctor.report_on(Console(file=printed, width=40), checks)
    return code, printed.getvalue()


def _finds(state, result, remedy=""):
    return lambda: CheckResult(state, result, remedy)


@pytest.mark.parametrize(
    ("checks", "code", "text"),
    [
        (
            [DoctorCheck("Python", _finds("ok", "3.11"))],
            0,
            "ok      Python: 3.11\nEverything required is installed.\n",
        ),
        (
            [DoctorCheck("ROS 2", _finds("missing", "No 'rclpy'", "pip install [this] and that"))],
            1,
            "missing ROS 2: No 'rclpy'\n        pip install [this] and that\nMissing: ROS 2.\n",
        ),
        (
            [DoctorCheck("EGL", _finds("warning", "absent", "apt install libegl1"))],
            0,
            "warning EGL: absent\n        apt install libegl1\nEverything required is installed.\n",
        ),
        (
            [
                DoctorCheck("ROS 2", _finds("missing", "absent")),
                DoctorCheck("DDS", lambda: pytest.fail("was tried"), needs=("ROS 2",)),
                DoctorCheck("Python", _finds("ok", "3.12")),
            ],
            1,
            (
                "missing ROS 2: absent\nskipped DDS: not checked without ROS 2\n"
                "ok      Python: 3.12\nMissing: ROS 2.\n"
            ),
        ),
    ],
    ids=["all well", "missing", "a warning is not missing", "what needs something missing"],
)
def test_each_check_has_a_line_and_its_remedy_stands_below(checks, code, text):
    """A narrow terminal does not break the remedy. One cause is reported once."""
    assert _report(*checks) == (code, text)


@pytest.mark.parametrize(
    ("minor", "state"), [(10, "missing"), (11, "ok"), (12, "ok"), (13, "ok"), (14, "missing")]
)
def test_python_is_fine_from_3_11_to_3_13(minor, state):
    """MuJoCo 4 needs 3.11; there are ROS wheels up to 3.13. The remedy names those that work."""
    finding = doctor.python((3, minor))
    assert finding.state == state
    if state == "missing":
        assert finding.text == f"3.{minor}"
        assert "3.11, 3.12 or 3.13" in finding.remedy


def test_without_a_browser_only_tests_are_skipped(tmp_path):
    """The finding says which."""
    finding = doctor.browser({"PATH": str(tmp_path)})
    assert (finding.state, finding.text) == ("warning", "not found")
    assert "apt install chromium" in finding.remedy
    (tmp_path / "chromium").touch(mode=0o755)
    assert doctor.browser({"PATH": str(tmp_path)}).state == "ok"


def test_without_a_compiler_only_installing_is_in_the_way(tmp_path):
    """What is installed runs without one."""
    finding = doctor.compiler({"PATH": str(tmp_path)})
    assert (finding.state, finding.remedy) == (
        "warning",
        "needed for installation: apt install g++",
    )


def test_packages_that_are_absent_are_named():
    """Each by the name that pip knows."""
    finding = doctor.packages(["rich", "no-such-package"])
    assert (finding.state, finding.text) == ("missing", "not installed: no-such-package")


@pytest.mark.process
def test_a_probe_that_fails_tells_its_reason():
    """The last line of the traceback is the reason."""
    assert doctor.probe("nothing") == CheckResult("missing", "KeyError: 'nothing'")


@pytest.mark.process
def test_a_probe_that_hangs_is_given_up():
    """A limit on the wall clock, since what hangs may be anything."""
    answer = doctor.probe("talk", "nobody_listens", limit_s=0.5)
    assert answer == CheckResult("missing", "no answer within 0.5 s")


@pytest.mark.process
def test_a_sourced_ros_of_another_release_is_missing():
    """Kilted's types have other hashes: nothing would be heard."""
    finding = doctor.ros({"ROS_DISTRO": "kilted"})
    assert finding.state == "missing"
    assert "kilted is sourced" in finding.text


@pytest.mark.process
def test_a_middleware_that_is_absent_is_named(monkeypatch):
    """Importing rclpy would end the process; the doctor survives it and names the variable."""
    monkeypatch.setenv("RMW_IMPLEMENTATION", "rmw_of_nobody_cpp")
    finding = doctor.middleware()
    assert (finding.state, finding.text) == (
        "missing",
        "RMW_IMPLEMENTATION=rmw_of_nobody_cpp cannot be loaded",
    )


@pytest.mark.process
def test_types_that_differ_on_a_topic_are_named(monkeypatch):
    """DDS says nothing of it, and nothing arrives."""
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    ends = []
    for name in ("patrol", "sim"):  # a participant each, as processes have
        context = Context()
        rclpy.init(context=context)
        ends.append((context, Node(name, context=context)))
    ends[0][1].create_publisher(Twist, "cmd_vel", 10)
    ends[1][1].create_subscription(TwistStamped, "cmd_vel", print, 10)
    finding = doctor.probe("types_agree", otherwise="warning", is_local=False)
    assert finding.state == "warning"
    assert finding.text == (
        "/cmd_vel: geometry_msgs/msg/Twist by /patrol published, "
        "but geometry_msgs/msg/TwistStamped by /sim taken"
    )
    for context, node in ends:
        node.destroy_node()
        context.shutdown()


@pytest.mark.thorough
@pytest.mark.process
def test_this_machine_has_what_the_tests_need():
    """The real checks, as a user runs them; rendering may be absent."""
    code, text = _report(*doctor.CHECKS)
    assert code == 0, text


@pytest.mark.parametrize(
    ("reach", "state", "words"),
    [
        ("", "ok", "ROS domain 3, this machine only; for a robot's own computer: --network"),
        ("LOCALHOST", "ok", "this machine only"),
        ("SUBNET", "warning", "ROS_AUTOMATIC_DISCOVERY_RANGE=SUBNET"),
        ("OFF", "warning", "ROS_AUTOMATIC_DISCOVERY_RANGE=OFF"),
    ],
)
def test_it_says_who_finds_our_processes(reach, state, words):
    """What is not this machine alone, or nobody, is a warning."""
    environment = {"ROS_DOMAIN_ID": "3", "ROS_AUTOMATIC_DISCOVERY_RANGE": reach}
    result = doctor.discovery(environment)
    assert result.state == state
    assert words in result.text
