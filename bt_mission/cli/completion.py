"""``bt-mission completion``: scripts with which shells complete our commands."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from bt_mission.cli.argument_types import input_file
from bt_mission.cli.commands import load_commands
from bt_mission.cli.completed_names import FILES, KINDS, known
from bt_mission.cli.exits import SUCCESS
from bt_mission.cli.outputs import OUTPUTS
from bt_mission.core.errors import BtMissionError

SHELLS = ("bash", "zsh", "fish")

EPILOG = """\
now, and in every new shell:
  bash:  echo 'source <(bt-mission completion bash)' >> ~/.bashrc
  zsh:   echo 'eval "$(bt-mission completion zsh)"' >> ~/.zshrc        after compinit
  fish:  bt-mission completion fish > ~/.config/fish/completions/bt-mission.fish

Names of missions, worlds and robots, of a mission's inputs, and of actions, topics, services,
executives and namespaces of the running graph are looked up when a word is completed.
"""

OF_KIND = {
    "mission": "missions",
    "world": "worlds",
    "robot": "robots",
    "params": "parameters",
    "set": "inputs",
    "vary": "inputs",
    "action": "actions",
    "topic": "topics",
    "service": "services",
    "executive": "executives",
    "namespace": "namespaces",
}
"""What is completed for an argument, by its name: these, and files of one's own."""

OF_COMMAND = {
    ("run", "file"): "runs",
    ("check", "files"): "runs",
    ("tree", "file"): "missions",
    ("convert", "file"): "missions",
    ("sweep", "file"): "runs",
    ("falsify", "file"): "runs",
    ("missions", "name"): "listed",
    ("worlds", "name"): "worlds",
    ("robots", "name"): "robots",
}
"""The same for arguments that mean something else elsewhere, by the command and their name."""

BASH = """\
_bt_mission_{kind}_file() {{
  local found suffix
  found=$(compgen -W "$(bt-mission completion --names {kind} 2>/dev/null)" -- "$1")
  if [[ -n $found ]]; then
    echo "$found"
    [[ $1 == */* ]] || return
  fi
  for suffix in {suffixes}; do
    compgen -f -X "!*.$suffix" -- "$1"
  done
  compgen -d -- "$1"
}}
"""
BASH_NAMES = """\
_bt_mission_{kind}_names() {{
  local found
  found=$(bt-mission completion --names {kind} --line "${{COMP_WORDS[*]}}" 2>/dev/null)
  compgen -W "$found" -- "$1"
}}
"""
BASH_END = """
# A name that ends with '=' is followed by its value. Words go onto the line as they are: what the
# shell would expand or run there is left to its own completion of files, which quotes it.
_bt_mission_complete() {
  _shtab_bt_mission
  local word special='*[[:cntrl:]"`$\\\\;&|<>()*?[!#{'\\'']*'
  local -a plain=()
  for word in "${COMPREPLY[@]}"; do
    [[ $word == $special ]] || plain+=("$word")
  done
  COMPREPLY=("${plain[@]}")
  if [[ ${#COMPREPLY[@]} -eq 1 && ${COMPREPLY[0]} == *= ]]; then
    compopt -o nospace 2>/dev/null
  fi
  return 0
}
complete -o bashdefault -F _bt_mission_complete bt-mission"""

ZSH = """\
_bt_mission_{kind}() {{
  local -a found
  found=(${{(f)"$(bt-mission completion --names {kind} 2>/dev/null)"}})
  _alternative "names:{kind}:($found)" 'files:file:_files -g "*.({alternatives})(-.)"'
}}
"""
ZSH_NAMES = """\
_bt_mission_{kind}() {{
  local -a found
  found=(${{(f)"$(bt-mission completion --names {kind} --line "$words" 2>/dev/null)"}})
  if [[ {kind} == inputs ]]; then
    compadd -q -S '' -a found
  else
    compadd -a found
  fi
}}
"""

FISH = "(bt-mission completion --names {kind}; __fish_complete_path (commandline -ct))"
FISH_NAMES = (
    "(bt-mission completion --names {kind} --line (commandline -cp | string collect) 2>/dev/null)"
)


def add_parser(commands: Any) -> None:
    """Add the command to the command line."""
    parser = commands.add_parser(
        "completion",
        description="Prints a script with which a shell completes commands, options, files, and "
        "the names of missions, worlds, robots, inputs, and of what is in the running graph.",
        epilog=EPILOG,
    )
    parser.add_argument("shell", nargs="?", choices=SHELLS, help="the shell")
    parser.add_argument(
        "--names", choices=tuple(KINDS), help="instead: print the names that are known, one a line"
    )
    parser.add_argument(
        "--line",
        default="",
        metavar="WORDS",
        help="with --names: the command line so far, which names the mission of inputs",
    )
    parser.set_defaults(command=completion)


def completion(options: argparse.Namespace) -> int:
    """Print the script, or names."""
    if (options.shell is None) == (options.names is None):
        raise BtMissionError(f"expected a shell ({', '.join(SHELLS)}), or --names")
    if options.names:
        for name in known(options.names, options.line):
            print(name)
    else:
        print(script(options.root, options.shell))
    return SUCCESS


def script(parser: argparse.ArgumentParser, shell: str) -> str:
    """The script for one shell."""
    import shtab

    load_commands(parser)
    for command, action in _actions(parser):
        how = _how(command, action)
        if how is not None:
            action.complete = how  # type: ignore[attr-defined]  # where shtab looks for it
    written = str(shtab.complete(parser, shell))
    return written + BASH_END if shell == "bash" else written


def _how(command: str, action: argparse.Action) -> Any:
    """How an argument is completed; None leaves it to shtab, which knows choices."""
    import shtab

    kind = OF_COMMAND.get((command, action.dest)) or OF_KIND.get(action.dest)
    if kind is not None and not action.choices:
        return _of_kind(kind)
    if action.dest == "images":
        return shtab.DIRECTORY
    return shtab.FILE if action.type in (Path, input_file, *OUTPUTS) else None


def _of_kind(kind: str) -> dict[str, Any]:
    """Names of a kind; and files, where those will do."""
    if kind not in FILES:
        return {
            "bash": f"_bt_mission_{kind}_names",
            "zsh": f"_bt_mission_{kind}",
            "fish": FISH_NAMES.format(kind=kind),
            "preamble": {"bash": BASH_NAMES.format(kind=kind), "zsh": ZSH_NAMES.format(kind=kind)},
        }
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
