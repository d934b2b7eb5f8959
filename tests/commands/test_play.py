"""``bt-mission play``: programs with the simulated robot, without a mission."""

from __future__ import annotations

import io
import json
import re
from pathlib import Path

import pytest

from tests.support.command_line import CommandLine
from tests.support.project import ROOT

CODE = ROOT / "docs" / "tutorials" / "code"
LATE = (
    "fibonacci: the cancel request waited 16 s: FibonacciServer.execute (sleepy_server.py:32) "
    "sleeps in the only thread of its executor; use a MultiThreadedExecutor and a "
    "ReentrantCallbackGroup [BT-920]"
)
EXPECTED = "expected a Python file, an installed module or console script, got"


@pytest.mark.parametrize(
    ("threads", "line", "warnings"),
    [
        ("", (20.0, "status 4, 22 numbers"), [LATE]),
        (" --threads", (5.0, "status 5, 7 numbers"), []),
    ],
)
def test_a_server_and_a_client_are_played(
    cli: CommandLine, threads: str, line: tuple[float, str], warnings: list[str]
) -> None:
    """It ends when the server only waits; the code is that of the programs."""
    server, client = f"{CODE}/sleepy_server.py", f"{CODE}/impatient_client.py"
    played = json.loads(cli(f"play {server} {client} --json --{threads}"))
    assert played["exit_codes"] == {"sleepy_server": None, "impatient_client": 0}
    assert played["lines"][-1] == [line[0], "impatient_client", line[1]]
    assert (played["time_s"], played["why"]) == (line[0], "idle")
    assert played["warnings"] == warnings


def test_a_deadlock_ends_the_run(cli: CommandLine, tmp_path: Path) -> None:
    """It is named with what helps; the end of the run prints nothing more of the programs."""
    server = (CODE / "sleepy_server.py").read_text(encoding="utf-8")
    program, client = tmp_path / "rate.py", CODE / "impatient_client.py"
    program.write_text(server.replace("time.sleep(1)", "self.create_rate(2).sleep()"))
    played = json.loads(cli(f"play {program} {client} --json", 1))
    assert played["lines"] == [[0.0, "impatient_client", "feedback 1"]]
    assert (played["why"], played["time_s"]) == ("failed", 0.05)
    assert played["failure"] == (
        "a deadlock: <module> (rate.py:46) spins, and FibonacciServer.execute (rate.py:32) sleeps "
        "on a rate; no thread of its executors is free: use a MultiThreadedExecutor and a "
        "ReentrantCallbackGroup [BT-919]"
    )


def test_a_server_that_listens_to_the_robot_ends_with_its_client(
    cli: CommandLine, tmp_path: Path
) -> None:
    """What it hears, and a rate on which nothing sleeps, are for goals; with --for it goes on."""
    server = (CODE / "sleepy_server.py").read_text(encoding="utf-8")
    program, client = tmp_path / "listens.py", CODE / "impatient_client.py"
    program.write_text(
        "from nav_msgs.msg import Odometry\n"
        + server.replace(
            "        self.server =",
            "        self.rate = self.create_rate(10)\n"
            "        self.create_subscription(Odometry, 'odom', lambda _: None, 10)\n"
            "        self.server =",
        ).replace("time.sleep(1)", "[self.rate.sleep() for _ in range(10)]"),
        encoding="utf-8",
    )
    words = f"play '{program} --threads' {client} --json"
    played = json.loads(cli(words))
    assert (played["why"], played["time_s"]) == ("idle", 5.0)
    played = json.loads(cli(f"{words} --for 6", 124))
    assert (played["why"], played["time_s"]) == ("limit", 6.0)


def test_a_program_uses_the_robot_until_its_time_is_over(cli: CommandLine, tmp_path: Path) -> None:
    """Scans and our action servers are there; what it prints has its time."""
    program = tmp_path / "listens.py"
    program.write_text(
        "import rclpy\n"
        "from bt_mission_interfaces.action import Turn\n"
        "from rclpy.action import ActionClient\n"
        "from rclpy.qos import qos_profile_sensor_data\n"
        "from sensor_msgs.msg import LaserScan\n"
        "rclpy.init()\n"
        "node = rclpy.create_node('listens')\n"
        "print(ActionClient(node, Turn, 'turn').wait_for_server(timeout_sec=1))\n"
        "node.create_subscription(LaserScan, 'scan', lambda _: print('scan'), "
        "qos_profile_sensor_data)\n"
        "rclpy.spin(node)\n",
        encoding="utf-8",
    )
    out = cli(f"play {program} --for 2", 124)
    assert "     0.25 s  listens: True\n" in out
    scans = out.count("listens: scan")
    assert scans >= 8
    assert out.endswith("listens: runs\n2 s: the time is over\n")
    kept = f"--record {tmp_path}/run.mcap --report {tmp_path}/run.html"
    out = cli(f"play {program} --for 2 --fault 'at 1.0: drop scan' --speed 1000 {kept}", 124)
    assert 0 < out.count("listens: scan") < scans - 3
    assert out.endswith(f"  recorded to {tmp_path}/run.mcap\n  report: {tmp_path}/run.html\n")
    shown = cli(f"replay {tmp_path}/run.mcap")
    assert "fault 1 begins: drop topic scan" in shown
    assert "    0.25 s    listens: True\n" in shown
    assert shown.count("listens: scan") == out.count("listens: scan")


def test_a_program_may_be_a_module_or_a_console_script(
    cli: CommandLine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As `python -m` runs it, or as pip installs it; both have their arguments."""
    package, installed = tmp_path / "fleet_tools", tmp_path / "fleet_tools-1.0.dist-info"
    for folder in (package, installed):
        folder.mkdir()
    (package / "__init__.py").write_text("", encoding="utf-8")
    (package / "words.py").write_text("hello = 'hello'\n", encoding="utf-8")
    (package / "says.py").write_text(
        "import sys, rclpy\nfrom .words import hello\n"
        "def main():\n    rclpy.init()\n    print(hello, __name__, *sys.argv[1:])\n    return 3\n"
        "if __name__ == '__main__':\n    main()\n",
        encoding="utf-8",
    )
    (installed / "METADATA").write_text("Metadata-Version: 2.1\nName: fleet_tools\nVersion: 1.0\n")
    (installed / "entry_points.txt").write_text(
        "[console_scripts]\ngreet = fleet_tools.says:main\n"
    )
    monkeypatch.syspath_prepend(str(tmp_path))
    out = cli("play fleet_tools.says 'greet b' -- --ros-args -p c:=1", 3)
    assert "says_1: hello __main__ --ros-args -p c:=1\n" in out
    assert "says_2: hello fleet_tools.says b --ros-args -p c:=1\n" in out
    mission = tmp_path / "greets.yaml"
    mission.write_text(
        "mission: m\nworld: empty_arena\nnodes: [{program: greet, arguments: [d], name: host}]\n"
        "tree: {wait: 1}\n",
        encoding="utf-8",
    )
    cli(f"run {mission}")
    assert "host: hello fleet_tools.says d\n" in cli.err


def test_commands_are_of_the_type_that_the_robot_takes(cli: CommandLine, tmp_path: Path) -> None:
    """The error names the option."""
    program = tmp_path / "drives.py"
    program.write_text(
        "import rclpy\nfrom geometry_msgs.msg import Twist\n"
        "rclpy.init()\nnode = rclpy.create_node('drives')\n"
        "node.create_publisher(Twist, 'cmd_vel', 10)\n",
        encoding="utf-8",
    )
    with pytest.raises(AssertionError):  # since there is the program's own traceback
        cli(f"play {program}", 1)
    assert "drives: the robot takes TwistStamped; " in cli.out
    assert "use --cmd-vel-type plain" in cli.out
    cli(f"play {program} --cmd-vel-type plain")


def test_a_program_may_ask(
    cli: CommandLine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its question is shown before it reads; what it logs is among the lines that it prints."""
    program = tmp_path / "asks.py"
    program.write_text(
        "import sys, time, rclpy\nrclpy.init()\nnode = rclpy.create_node('n')\n"
        "speed = float(input('speed: '))\nprint('name', end=' ')\n"
        "name = sys.stdin.readline().strip()\ntime.sleep(0.5)\n"
        "node.get_logger().warning(f'{name}\\nat {speed}')\n",
        encoding="utf-8",
    )
    monkeypatch.setattr("sys.stdin", io.StringIO("0.25\nmine\n"))
    assert cli(f"play {program}").splitlines()[:-2] == [
        "     0.00 s  asks: speed: ",
        "     0.00 s  asks: name ",
        "     0.50 s  asks: [WARN] [n]: mine",
        "     0.50 s  asks: at 0.25",
    ]


def test_code_that_holds_the_clock_is_named(cli: CommandLine, tmp_path: Path) -> None:
    """With --strict it fails."""
    program = tmp_path / "computes.py"
    program.write_text(
        "import time, rclpy\nrclpy.init()\ntime.sleep(0.1)\nend = time.process_time() + 2.5\n"
        "for _ in iter(lambda: time.process_time() < end, False):\n    pass\n",
        encoding="utf-8",
    )
    out = cli(f"play {program} --strict", 1)
    wrong = r"the times are wrong: <module> \(computes.py:[56]\) held the clock \[BT-918\]\n$"
    assert re.search(wrong, out), out


@pytest.mark.parametrize(
    ("word", "message"),
    [
        ("/", f"{EXPECTED} '/'"),
        ("''", f"{EXPECTED} ''"),
        ("none.none", f"{EXPECTED} 'none.none'"),
        ("mine.yaml", f"{EXPECTED} 'mine.yaml'"),
        ("absent.py", "no such file: absent.py; it is looked for in /"),
        ("self.py", "no such file: self.py; it is looked for in /"),
        ('"\\""', "the arguments cannot be read: No closing quotation"),
    ],
)
def test_what_is_no_program_is_refused(cli: CommandLine, word: str, message: str) -> None:
    """With what it is."""
    (cli.folder / "self.py").symlink_to("self.py")
    cli(f"play {word}", 2)
    assert cli.err.startswith(message)
    assert cli.err.endswith("[BT-215]\n")


def test_ctrl_c_is_sent_to_the_programs(cli: CommandLine, tmp_path: Path) -> None:
    """Each gets KeyboardInterrupt where it waits, and ends with its own exit code."""
    head = "import os, signal, time, rclpy\nrclpy.init()\n"
    waits = (
        "node = rclpy.create_node('waits')\n"
        "try:\n    rclpy.spin(node)\nexcept KeyboardInterrupt:\n    raise SystemExit(3)\n"
    )
    sends = (
        "time.sleep(1)\nos.kill(os.getpid(), signal.SIGINT)\n"
        "try:\n    time.sleep(60)\nexcept KeyboardInterrupt:\n    print('stopped')\n"
    )
    for name, code in (("waits", waits), ("sends", sends)):
        (tmp_path / f"{name}.py").write_text(head + code, encoding="utf-8")
    out = cli(f"play {tmp_path}/waits.py {tmp_path}/sends.py", 3)
    assert "     1.00 s  sends: stopped\n" in out
    assert out.endswith("waits: exit code 3\nsends: exit code 0\n1 s: all programs have ended\n")


def test_no_time_passes_at_a_breakpoint(
    cli: CommandLine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The debugger reads from the terminal and writes to it; then the program goes on."""
    program, terminal = tmp_path / "stops.py", io.StringIO()
    program.write_text(
        "import time, rclpy\nrclpy.init()\nstart = time.monotonic_ns()\nbreakpoint()\n"
        "time.sleep(1)\nprint(time.monotonic_ns() - start)\n",
        encoding="utf-8",
    )
    monkeypatch.setattr("sys.stdin", io.StringIO("p 6 * 7\nc\n"))
    monkeypatch.setattr("sys.__stdout__", terminal)
    out = cli(f"play {program}")
    assert "(Pdb) 42\n" in terminal.getvalue()
    assert "     1.00 s  stops: 1000000000\n" in out


def test_what_cannot_be_played_is_refused(cli: CommandLine, tmp_path: Path) -> None:
    """With what is wrong; a program that fails ends with its code."""
    cli(f"play {tmp_path}/none.py", 2)
    assert "none.py [BT-215]" in cli.err
    failing = tmp_path / "fails.py"
    failing.write_text("import rclpy, sys\nrclpy.init()\nsys.exit('no map')\n", encoding="utf-8")
    out = cli(f"play {failing}", 1)
    assert out == ("     0.00 s  fails: no map\nfails: exit code 1\n0 s: all programs have ended\n")
