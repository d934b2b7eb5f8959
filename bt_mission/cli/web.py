"""The options of commands that show a mission in a browser, and what they do."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import replace
from functools import partial
from importlib.util import find_spec
from typing import TYPE_CHECKING

from bt_mission.base.errors import BtMissionError
from bt_mission.cli.argument_types import port
from bt_mission.cli.parser import Option, each

if TYPE_CHECKING:
    from bt_mission.views.web.live import LiveMission
    from bt_mission.views.web.server import PageServer, WebOptions, WebServer

PORT, LOOPBACK = 8080, "127.0.0.1"
GROUP = "in a browser"
NEEDED = ("starlette", "uvicorn", "websockets")
ENDED = "the mission has ended"

UNSAFE = """\
--host {host}: other machines can reach the page. Everyone with the link can {what}. The link and \
the page are sent unencrypted. Use a tunnel to keep both private: omit --host, \
and on the other machine run  ssh -L {port}:127.0.0.1:{port} THIS_MACHINE"""


def require_server(option: str) -> None:
    """Refuse an option without the packages that serve it.

    Raises:
        BtMissionError: With what to install.
    """
    missing = [name for name in NEEDED if find_spec(name) is None]
    if missing:
        needed = " and ".join(missing)
        raise BtMissionError(
            f"{option} needs {needed}: pip install 'bt-mission[web]'", code="BT-905"
        )


def web_options(*instead: str) -> tuple[Option, ...]:
    """Return whether the mission is shown in a browser, and how.

    Args:
        instead: Options of the command that show it in another way.
    """
    return (
        Option(
            "--web",
            "show the mission in a browser, and print the link",
            group=GROUP,
            excludes=each(*instead),
            check=partial(require_server, "--web"),
        ),
        *page_options("the page cannot control the mission", "web"),
    )


def page_options(read_only: str, *needs: str) -> tuple[Option, ...]:
    """Return the address of a page, and what it may do.

    Args:
        read_only: What it cannot do with `--read-only`.
        needs: The options with which there is a page.
    """
    of_page = Option("", "", group=GROUP, needs=each(*needs))
    return (
        of_page.but(
            form="--port N",
            help=f"listen on this port (default: {PORT}; 0: any free port)",
            type=port,
        ),
        of_page.but(form="--open", help="open the page in your browser"),
        of_page.but(form="--read-only", help=read_only),
        of_page.but(
            form="--host ADDRESS",
            help="listen on this address (default: 127.0.0.1, which other machines cannot reach)",
        ),
    )


@contextmanager
def web_server(
    options: argparse.Namespace, shown: LiveMission, *, is_fast: bool = False
) -> Iterator[WebServer]:
    """A server of a mission that listens; its link is printed, and opened where that is wanted.

    Args:
        options: Those of the page.
        shown: What it shows.
        is_fast: Is it a mission of this process that goes faster than in real time?

    Raises:
        BtMissionError: Where it cannot listen.
    """
    from bt_mission.views.web.server import FAST_FRAME_S, WebServer

    place = place_of(options)
    server = WebServer(shown, replace(place, frame_s=FAST_FRAME_S) if is_fast else place)
    with announced(options, server):
        yield server


@contextmanager
def page_server(options: argparse.Namespace, page: str) -> Iterator[PageServer]:
    """As :func:`web_server`, of a page that has all of its data."""
    from bt_mission.views.web.server import PageServer

    server = PageServer(page, place_of(options))
    with announced(options, server):
        yield server


def place_of(options: argparse.Namespace) -> WebOptions:
    """Return where a page is served, and what it may do."""
    from bt_mission.views.web.server import WebOptions

    return WebOptions(options.host or LOOPBACK, _port_of(options), options.read_only)


@contextmanager
def announced(options: argparse.Namespace, server: PageServer, what: str = "") -> Iterator[None]:
    """Print the link of a server that listens, open it where that is wanted, and close it.

    Args:
        options: Those of the page.
        server: The server.
        what: What everyone with the link can do.
    """
    from bt_mission.views.web.gate import is_loopback

    host = options.host or LOOPBACK
    with closing(server):
        if not is_loopback(host):
            what = what or (
                "watch the mission" if options.read_only else "watch and stop the mission"
            )
            print(UNSAFE.format(host=host, what=what, port=server.port), file=sys.stderr)
        to_stderr(f"in a browser: {server.link}")
        if options.open:
            _open(server.link)
        yield


def _port_of(options: argparse.Namespace) -> int:
    number: int = PORT if options.port is None else options.port
    return number


def _open(link: str) -> None:
    import webbrowser

    if not webbrowser.open(link):
        print("--open: no browser found; open the link yourself", file=sys.stderr)


@contextmanager
def watching_process(options: argparse.Namespace, name: str) -> Iterator[None]:
    """Another process that shows an executive of this one's graph, if a page is wanted.

    A robot's executive serves no browsers itself, so failures of the page do not affect it.

    Args:
        name: Of the executive.
    """
    if not options.web:
        yield
        return
    from bt_mission.views.web.guarded_server import listening_socket

    listening_socket(options.host or LOOPBACK, _port_of(options)).close()  # or say so at once
    with watch_beside(name, *web_arguments(options)):
        yield


@contextmanager
def watch_beside(*words: str) -> Iterator[None]:
    """Run ``bt-mission watch`` with these words in another process, and end it afterwards."""
    import subprocess

    from bt_mission.base.python_process import python_command, python_environment

    command = python_command("-m", "bt_mission", "watch", *words, "--until-input-ends")
    process = subprocess.Popen(  # noqa: S603 - this Python with a command of ours
        command, stdin=subprocess.PIPE, start_new_session=True, env=python_environment()
    )
    try:
        yield
    finally:
        assert process.stdin is not None, "it was asked for"
        process.stdin.close()
        process.wait()


def page_stays(verdict: str) -> str:
    """Return the line for the user after the end of a mission, with its verdict."""
    return f"{ENDED}: {verdict}; the page stays until Ctrl-C"


def stay_until_left(status: str) -> None:
    """Let the page be looked at when the mission has ended with this status, until Ctrl-C."""
    from bt_mission.base.interrupts import InterruptSignals
    from bt_mission.base.wall_clock import LONGEST_SLEEP_S, rest

    to_stderr(page_stays(status))
    with InterruptSignals() as leaving:
        while not leaving.count:
            rest(LONGEST_SLEEP_S)


def web_arguments(options: argparse.Namespace) -> list[str]:
    """The same options for another process."""
    given = [
        option
        for option in options.parser.options
        if option.group == GROUP and option.is_given(options)
    ]
    return [
        option.name if option.is_flag else f"{option.name}={getattr(options, option.attribute)}"
        for option in given
    ]


def has_input_ended() -> bool:
    """Has the parent process ended? Reads standard input without waiting."""
    import select

    readable, _, _ = select.select([sys.stdin], [], [], 0)
    return bool(readable) and not os.read(sys.stdin.fileno(), 1024)


def to_stderr(text: str) -> None:
    """Tell people something beside the output."""
    print(text, file=sys.stderr, flush=True)
