"""``bt-mission completion``: scripts with which shells complete our commands."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from bt_mission.cli.commands import load_commands
from bt_mission.cli.exits import SUCCESS
from bt_mission.core.errors import BtMissionError
from bt_mission.core.files import fleets, names, scenarios

SHELLS = ("bash", "zsh", "fish")
KINDS = ("missions", "runs", "worlds", "robots", "parameters")
"""What is completed by name; runs are missions, scenarios and fleets."""

EPILOG = """\
now, and in every new shell:
  bash:  echo 'source <(bt-mission completion bash)' >> ~/.bashrc
  zsh:   echo 'eval "$(bt-mission completion zsh)"' >> ~/.zshrc        after compinit
  fish:  bt-mission completion fish > ~/.config/fish/completions/bt-mission.fish

Names of missions, worlds and robots are looked up when a word is completed.
"""

OF_KIND = {"mission": "missions", "world": "worlds", "robot": "robots", "params": "parameters"}
"""What is completed after an option, by its name: these, and files of one's own."""

MISSION_COMMANDS = {"run": "runs", "check": "runs", "tree": "missions", "convert": "missions"}
"""What the argument ``file`` of a command is."""

BASH = """\
_bt_mission_{kind}_file() {{
  local found suffix
  found=$(compgen -W "$(bt-mission completion --names {kind} 2>/dev/null)" -- "$1")
  if [[ -n $found && $1 != */* ]]; then
    echo "$found"
    return
  fi
  for suffix in {suffixes}; do
    compgen -f -X "!*.$suffix" -- "$1"
  done
  compgen -d -- "$1"
}}
"""
ZSH = """\
_bt_mission_{kind}() {{
  local -a found
  found=(${{(f)"$(bt-mission completion --names {kind} 2>/dev/null)"}})
  _alternative "names:{kind}:($found)" 'files:file:_files -g "*.({alternatives})(-.)"'
}}
"""
_PLAIN_NAME = re.compile(r"[\w.+@%/-]+", re.ASCII)
"""Names that a shell takes as they are: it expands `$(...)` and blanks in what it completes."""

FISH = "(bt-mission completion --names {kind}; __fish_complete_path (commandline -ct))"


def add_parser(commands: Any) -> None:
    """Add the command to the command line."""
    parser = commands.add_parser(
        "completion",
        description="Prints a script with which a shell completes commands, options, files, and "
        "the names of missions, worlds and robots.",
        epilog=EPILOG,
    )
    parser.add_argument("shell", nargs="?", choices=SHELLS, help="the shell")
    parser.add_argument(
        "--names", choices=KINDS, help="instead: print the names that are known, one a line"
    )
    parser.set_defaults(command=completion)


def completion(options: argparse.Namespace) -> int:
    """Print the script, or names."""
    if (options.shell is None) == (options.names is None):
        raise BtMissionError(f"expected a shell ({', '.join(SHELLS)}), or --names")
    if options.names:
        print("\n".join(filter(_PLAIN_NAME.fullmatch, known(options.names))))
    else:
        print(script(options.root, options.shell))
    return SUCCESS


def known(kind: str) -> list[str]:
    """Return the names that are completed."""
    return [*names("missions"), *scenarios(), *fleets()] if kind == "runs" else names(kind)  # type: ignore[arg-type]  # one of KINDS


def script(parser: argparse.ArgumentParser, shell: str) -> str:
    """The script for one shell."""
    import shtab

    load_commands(parser)
    for command, action in _actions(parser):
        how = _how(command, action)
        if how is not None:
            action.complete = how  # type: ignore[attr-defined]  # where shtab looks for it
    return str(shtab.complete(parser, shell))


def _how(command: str, action: argparse.Action) -> Any:
    """How an argument is completed; None leaves it to shtab, which knows choices."""
    import shtab

    kind = OF_KIND.get(action.dest)
    if action.dest in ("file", "files") and command in MISSION_COMMANDS:
        kind = MISSION_COMMANDS[command]
    if kind is not None:
        return _named(kind)
    if action.dest == "images":
        return shtab.DIRECTORY
    return shtab.FILE if action.type is Path else None


def _named(kind: str) -> dict[str, Any]:
    """Names of a kind, and files."""
    suffixes = ("yaml", "yml", "xml") if kind in ("missions", "runs") else ("yaml", "yml")
    filled = {"kind": kind, "suffixes": " ".join(suffixes), "alternatives": "|".join(suffixes)}
    return {
        "bash": f"_bt_mission_{kind}_file",
        "zsh": f"_bt_mission_{kind}",
        "fish": FISH.format(**filled),
        "preamble": {"bash": BASH.format(**filled), "zsh": ZSH.format(**filled)},
    }


def _actions(
    parser: argparse.ArgumentParser, command: str = ""
) -> Iterator[tuple[str, argparse.Action]]:
    """All arguments of all commands, with the command's name."""
    for action in parser._actions:  # noqa: SLF001 - argparse has no public way to its arguments
        if isinstance(action.choices, dict):
            for name, inner in action.choices.items():
                yield from _actions(inner, command or name)
        else:
            yield command, action
