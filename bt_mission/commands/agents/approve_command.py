"""``bt-mission approve``: a person permits one drive of a proposal."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from shutil import get_terminal_size

from bt_mission.base.text import escape_control
from bt_mission.cli.argument_types import port
from bt_mission.cli.exits import MISSION_FAILED, SUCCESS
from bt_mission.cli.parser import Command, Option, each
from bt_mission.commands.agents.mcp_command import AGENTS, site_of, site_option

KEY = Path("~/.config/bt-mission/approve.pem")
PORT = 8771

EPILOG = """\
examples:
  bt-mission approve --new-key                     once; prints the line for the site's file
  bt-mission approve --site site.yaml              list the proposals
  bt-mission approve tour --site site.yaml         show one, and ask
  bt-mission approve --site site.yaml --web        the same on a page of this machine

exit codes: 0 approved, listed, a key was made, or the page ended; 1 not approved; 2 bad input
"""


def approve(options: argparse.Namespace) -> int:
    """Show a proposal, ask, and sign; return the exit code."""
    key: Path = options.key.expanduser()
    if options.new_key:
        return _make_key(key)
    if options.web:
        return _serve(options, key)
    if options.proposal is None:
        return _list(options)
    from bt_mission.commands.agents.evidence import EvidenceError
    from bt_mission.commands.agents.permits import ApprovalError, grant, has_passphrase, read_key
    from bt_mission.commands.agents.shown import Shown

    site, folder = site_of(options)
    shown = Shown.of(folder, site, options.proposal)
    for line in shown.lines(sys.stdout.encoding, get_terminal_size().columns):
        print(escape_control(line))
    if shown.missing:
        raise EvidenceError("; ".join(shown.missing))
    if not (sys.stdin.isatty() and sys.stdout.isatty()):
        raise ApprovalError("approve asks a person: run it in a terminal")
    expires = f"within {site.written.expires:g} s, once"
    try:
        answer = input(f"\nType the name of the proposal to let it drive {expires}: ")
    except EOFError:  # Ctrl-D
        answer = ""
    if answer.strip() != shown.proposal.name:
        print("not approved")
        return MISSION_FAILED
    passphrase = _ask("passphrase of the key: ") if has_passphrase(key) else ""
    grant(folder, site, shown.proposal, shown.evidence, read_key(key, passphrase))
    print(f"approved: '{shown.proposal.name}' may drive {expires}")
    return SUCCESS


def _serve(options: argparse.Namespace, key: Path) -> int:
    """Serve the page until Ctrl-C."""
    import asyncio
    from contextlib import closing

    from bt_mission.base.interrupts import InterruptSignals
    from bt_mission.commands.agents.approval_page import ApprovalServer

    _, folder = site_of(options)
    number = PORT if options.port is None else options.port
    with (
        InterruptSignals() as leaving,
        closing(ApprovalServer(options.site, folder, key, number)) as server,
    ):
        print(f"in a browser: {server.link}", file=sys.stderr, flush=True)
        asyncio.run(server.serve(lambda: leaving.count > 0))
    return SUCCESS


def _list(options: argparse.Namespace) -> int:
    from bt_mission.commands.agents.shown import states

    site, folder = site_of(options)
    for name, state in states(folder, site):
        print(f"{name}: {state}")
    if not folder.names():
        print(f"no proposals in {folder.root}")
    return SUCCESS


def _make_key(path: Path) -> int:
    from bt_mission.commands.agents.permits import ApprovalError, new_key

    passphrase = ""
    if sys.stdin.isatty():
        passphrase = _ask("passphrase of the new key (empty: none): ")
        if passphrase != _ask("again: "):
            raise ApprovalError("the passphrases differ")
    print(f'approvers: ["{new_key(path, passphrase)}"]')
    print(f"{path}: the key; the line above belongs into the site's file", file=sys.stderr)
    return SUCCESS


def _ask(prompt: str) -> str:
    from getpass import getpass

    from bt_mission.commands.agents.permits import ApprovalError

    try:
        return getpass(prompt)
    except EOFError:
        raise ApprovalError("no passphrase was typed") from None


COMMANDS = {
    "approve": Command(
        approve,
        "Shows a proposal of an agent: the mission, its changes since the last approval, the "
        "evidence, and the map of the worst simulated run. After a person has typed its name, "
        "writes a permit. With --web this happens in a browser. The permit serves for one drive, "
        "expires, and is void as soon as the mission, its inputs, the site, its robot or world, "
        "or the evidence changes.",
        (
            Option("proposal", "the name of a proposal (default: list them)", nargs="?"),
            site_option("bt-mission approve"),
            AGENTS,
            Option("--key FILE", f"the private key of the person (default: {KEY})", Path, KEY),
            Option(
                "--web",
                "show the proposals on a page of this machine, with a form to approve; the key "
                "must have a passphrase",
                excludes=each("proposal"),
            ),
            Option(
                "--port N",
                f"listen on this port (default: {PORT}; 0: any free port)",
                port,
                needs=each("web"),
            ),
            Option(
                "--new-key",
                "make a key with an optional passphrase, and print its public part",
                excludes=each("site"),
            ),
        ),
        EPILOG,
    )
}
