"""``bt-mission doctor``: what this machine has, what it lacks, and what to install."""

from __future__ import annotations

import argparse
import importlib.metadata
import os
import shutil
import signal
import subprocess
import sys
import sysconfig
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from bt_mission.base.commands import ROWS, all_rows, unusable_rows
from bt_mission.base.dds.discovery import MACHINE, PROCESS, RANGE
from bt_mission.base.python_process import python_command, python_environment
from bt_mission.base.text import counted
from bt_mission.cli.parser import Command

if TYPE_CHECKING:
    from rich.console import Console

PROBE_LIMIT_S = 30.0
"""How long a probe may take before it counts as hung, in seconds of the wall clock."""

PACKAGES = ("mujoco", "py-trees", "numpy", "scipy", "pillow", "pydantic", "pyyaml", "rich")
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
"""Browsers for tests of pages."""

RMW = "RMW_IMPLEMENTATION"
"""Where it names a middleware that is absent, importing rclpy ends the process."""

REINSTALL = "pip install bt-mission, or `make demo` in a checkout"

REAL_TIME = "run in real time: bt-mission sim, servers, run --attach"
RENDERING = "the camera is slower without it: apt install libegl1 libgl1-mesa-dri libopengl0"

SAME_TYPE = (
    "DDS connects equal types only. For velocity commands: bt-mission sim --cmd-vel-type, the "
    "parameter cmd_vel_type of servers and arbiter, enable_stamped_cmd_vel of the robot's bringup"
)

State = Literal["ok", "warning", "missing", "skipped"]
STYLES: Mapping[State, str] = {
    "ok": "green",
    "warning": "yellow",
    "missing": "bold red",
    "skipped": "dim",
}


def doctor(_: argparse.Namespace) -> int:
    """Run all checks; 0 when everything needed is there."""
    from bt_mission.views.terminal.console import EscapingConsole

    return report_on(EscapingConsole(sys.stdout))


@dataclass(frozen=True)
class CheckResult:
    """What one check found; `remedy` says what to do unless the state is "ok"."""

    state: State
    text: str
    remedy: str = ""


@dataclass(frozen=True)
class DoctorCheck:
    """One line of the report: what it is about, how to find out, and what that needs first."""

    subject: str
    find: Callable[[], CheckResult]
    needs: tuple[str, ...] = ()


def probe(
    name: str,
    *arguments: str,
    otherwise: State = "missing",
    remedy: str = "",
    without: tuple[str, ...] = (),
    limit_s: float = PROBE_LIMIT_S,
    is_local: bool = True,
) -> CheckResult:
    """Run one of `bt_mission.cli.doctor_probes` in a separate process.

    Args:
        name: Of the probe.
        arguments: Of the probe.
        otherwise: The state of the result where the probe fails; its text is the reason then.
        remedy: What to do about it.
        without: Names of variables that the probe shall not find in its environment.
        limit_s: Seconds of the wall clock after which it counts as hung.
        is_local: It hears this machine only, whatever the environment says.
    """

    def failed(reason: str) -> CheckResult:
        return CheckResult(otherwise, reason, remedy)

    try:
        ended = subprocess.run(
            _command(name, *arguments),
            capture_output=True,
            text=True,
            errors="replace",
            timeout=limit_s,
            check=False,
            env=_environment(without, is_local=is_local),
        )
    except subprocess.TimeoutExpired:
        return failed(f"no answer within {limit_s:g} s")
    if ended.returncode < 0:
        return failed(f"crashed ({signal.Signals(-ended.returncode).name})")
    output = ended.stdout if ended.returncode == 0 else ended.stderr
    lines = [line.strip() for line in output.splitlines() if line.strip()]
    last = lines[-1] if lines else "no reason given"
    return CheckResult("ok", last) if ended.returncode == 0 else failed(last)


def _command(name: str, *arguments: str) -> list[str]:
    return python_command("-m", "bt_mission.cli.doctor_probes", name, *arguments)


def _environment(without: tuple[str, ...] = (), *, is_local: bool = True) -> dict[str, str]:
    # As every command that lets a second terminal attach: this machine, and no further.
    mine = python_environment()
    if is_local or not mine.get(RANGE):
        mine[RANGE] = MACHINE
    return {name: value for name, value in mine.items() if name not in without}


def python(version: tuple[int, int] = sys.version_info[:2]) -> CheckResult:
    """3.11 to 3.13: MuJoCo 4 needs 3.11, and there are no ROS wheels beyond 3.13."""
    text = ".".join(map(str, version))
    if (3, 11) <= version < (3, 14):
        return CheckResult("ok", text)
    return CheckResult("missing", text, "install Python 3.11, 3.12 or 3.13")


def compiler(environ: Mapping[str, str] = os.environ) -> CheckResult:
    """A C++ compiler and Python's headers, which only installing needs."""
    names = (environ.get("CXX", "c++"), "g++", "clang++")
    path = environ.get("PATH")
    compiler = next(filter(None, (shutil.which(name, path=path) for name in names)), None)
    if compiler is None:
        return CheckResult("warning", "not found", "needed for installation: apt install g++")
    if not Path(sysconfig.get_path("include"), "Python.h").is_file():
        remedy = "needed for installation: apt install python3-dev"
        return CheckResult("warning", f"{compiler}, without Python's C headers", remedy)
    return CheckResult("ok", compiler)


def browser(environ: Mapping[str, str] = os.environ) -> CheckResult:
    """A Chromium, which only tests of pages need."""
    path = environ.get("PATH")
    browser = next(filter(None, (shutil.which(name, path=path) for name in BROWSERS)), None)
    if browser is None:
        remedy = (
            "only `make test` needs it, and skips tests of pages without it: apt install chromium"
        )
        return CheckResult("warning", "not found", remedy)
    return CheckResult("ok", browser)


def packages(names: Iterable[str] = PACKAGES) -> CheckResult:
    """The Python packages beside ROS."""
    versions, absent = [], []
    for name in names:
        try:
            versions.append(f"{name} {importlib.metadata.version(name)}")
        except importlib.metadata.PackageNotFoundError:
            absent.append(name)
    if absent:
        return CheckResult("missing", f"not installed: {', '.join(absent)}", REINSTALL)
    return CheckResult("ok", ", ".join(versions))


def ros(environ: Mapping[str, str] = os.environ) -> CheckResult:
    """The ROS 2 that this Python imports: the wheels, or an installed Jazzy."""
    answer = probe("ros", remedy=f"{REINSTALL}; or source an installed ROS 2 Jazzy", without=(RMW,))
    sourced = environ.get("ROS_DISTRO")
    if answer.state == "ok" and sourced is not None and sourced != "jazzy":
        remedy = "use a shell in which no other ROS is sourced"
        return CheckResult("missing", f"{answer.text}; ROS 2 {sourced} is sourced", remedy)
    return answer


def middleware(environ: Mapping[str, str] = os.environ) -> CheckResult:
    """The RMW that is loaded; virtual time was proven with one."""
    answer = probe("rmw", remedy=REINSTALL)
    if answer.state == "ok" and answer.text != "rmw_fastrtps_cpp":
        remedy = f"unset {RMW}; virtual time was tested only with rmw_fastrtps_cpp"
        return CheckResult("warning", answer.text, remedy)
    if answer.state != "ok" and RMW in environ:
        remedy = f"unset {RMW}, or install this middleware"
        return CheckResult("missing", f"{RMW}={environ[RMW]} cannot be loaded", remedy)
    return answer


def discovery(environ: Mapping[str, str] = os.environ) -> CheckResult:
    """Which machines find our processes, and how that is changed."""
    domain, reach = environ.get("ROS_DOMAIN_ID") or "0", environ.get(RANGE)
    if not reach:
        return CheckResult(
            "ok", f"ROS domain {domain}, this machine only; for a robot's own computer: --network"
        )
    settings = f"ROS domain {domain}, {RANGE}={reach}"
    if reach == PROCESS:
        return CheckResult("warning", settings, f"unset {RANGE} to join other processes")
    if reach == MACHINE:
        return CheckResult("ok", f"{settings}: this machine only")
    remedy = (
        f"every machine on the network can command nodes on this machine; unset {RANGE} for "
        f"simulations"
    )
    return CheckResult("warning", settings, remedy)


def loopback() -> CheckResult:
    """DDS between two processes on this machine, as --attach and a second terminal need it."""
    topic = f"bt_mission_doctor_{os.getpid()}"
    talker = subprocess.Popen(
        _command("talk", topic),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        env=_environment(),
    )
    remedy = "allow multicast and UDP on the loopback interface, and make /dev/shm writable"
    try:
        return probe("listen", topic, remedy=remedy)
    finally:
        talker.kill()
        talker.wait()


def commands() -> CheckResult:
    """The commands that are there, and those that other packages bring."""
    there = all_rows()
    absent = [row.name for row in ROWS if row.name not in there]
    others = [name for name, row in there.items() if row not in ROWS]
    text = "; ".join(
        [
            counted(sum(bool(row.help) for row in there.values()), "command"),
            *([f"of other packages: {', '.join(others)}"] if others else ()),
            *([f"not installed: {', '.join(absent)}"] if absent else ()),
        ]
    )
    if unusable := unusable_rows():
        remedy = "correct or uninstall the package"
        return CheckResult("warning", "; ".join([text, *unusable]), remedy)
    return CheckResult("ok", text)


CHECKS = (
    DoctorCheck("Python", python),
    DoctorCheck("C++ compiler", compiler),
    DoctorCheck("Python packages", packages),
    DoctorCheck("ROS 2", ros),
    DoctorCheck(
        "interfaces",
        partial(probe, "types", remedy=f"install the interfaces: {REINSTALL}", without=(RMW,)),
        needs=("ROS 2",),
    ),
    DoctorCheck("middleware", middleware, needs=("ROS 2",)),
    DoctorCheck("discovery", discovery),
    DoctorCheck("DDS between processes", loopback, needs=("ROS 2", "middleware")),
    DoctorCheck(
        "topic types",
        partial(probe, "types_agree", otherwise="warning", remedy=SAME_TYPE, is_local=False),
        needs=("ROS 2", "middleware"),
    ),
    DoctorCheck(
        "virtual clock", partial(probe, "lockstep", remedy=REAL_TIME), needs=("ROS 2", "middleware")
    ),
    DoctorCheck(
        "off-screen rendering",
        partial(probe, "render", otherwise="warning", remedy=RENDERING),
        needs=("Python packages",),
    ),
    DoctorCheck(
        "plug-ins",
        partial(probe, "plugins", otherwise="warning", remedy="see docs/tutorials/own-leaf.md"),
        needs=("Python packages",),
    ),
    DoctorCheck("commands", commands),
    DoctorCheck("Chromium", browser),
)


def report_on(console: Console, checks: Iterable[DoctorCheck] = CHECKS) -> int:
    """Print each finding as it is made; return 0 when everything needed is there, or else 1."""
    from rich.text import Text

    missing: list[str] = []
    for check in checks:
        lacking = [subject for subject in check.needs if subject in missing]
        if lacking:
            finding = CheckResult("skipped", f"not checked without {' and '.join(lacking)}")
        else:
            finding = check.find()
        if finding.state == "missing":
            missing.append(check.subject)
        mark = (f"{finding.state:8}", STYLES[finding.state])
        console.print(Text.assemble(mark, f"{check.subject}: {finding.text}"), soft_wrap=True)
        if finding.remedy:
            console.print(Text(f"{'':8}{finding.remedy}"), soft_wrap=True)
    verdict = f"Missing: {', '.join(missing)}." if missing else "Everything required is installed."
    console.print(Text(verdict), soft_wrap=True)
    return 1 if missing else 0


COMMANDS = {
    "doctor": Command(
        doctor,
        "Checks Python, ROS 2, the message types, off-screen rendering, DDS on loopback and the "
        "virtual clock. Names what to install if something is missing.",
    )
}
