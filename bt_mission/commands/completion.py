"""``bt-mission completion``: scripts that complete commands in shells, and names for them."""

from __future__ import annotations

import argparse
import re
import shlex
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from bt_mission.base.commands import loaded, points
from bt_mission.base.errors import BtMissionError
from bt_mission.base.files import SUFFIXES, fleets, is_file, kind_of, look_for, names, scenarios
from bt_mission.cli.argument_types import FileType
from bt_mission.cli.exits import SUCCESS
from bt_mission.cli.parser import Command, Option
from bt_mission.cli.subparsers import called, load_commands

SHELLS = ("bash", "zsh", "fish")

EPILOG = """\
to activate it now and in every new shell:
  bash:  echo 'source <(bt-mission completion bash)' >> ~/.bashrc
  zsh:   echo 'eval "$(bt-mission completion zsh)"' >> ~/.zshrc        (after compinit)
  fish:  bt-mission completion fish > ~/.config/fish/completions/bt-mission.fish

Names of missions, worlds and robots, of a mission's inputs, and of actions, topics, services,
executives and namespaces of the running graph are looked up at each completion.
"""

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
# shell would expand or run there is completed by its completion of files, which quotes it.
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


def completion(options: argparse.Namespace) -> int:
    """Print the script, or names."""
    if (options.shell is None) == (options.names is None):
        raise BtMissionError(f"expected a shell ({', '.join(SHELLS)}), or --names", code="BT-1101")
    if options.names:
        for name in known(options.names, options.line):
            print(name)
    else:
        print(script(options.root, options.shell))
    return SUCCESS


def script(parser: argparse.ArgumentParser, shell: str) -> str:
    """The script for one shell."""
    import shtab

    for action in _actions(load_commands(parser)):
        option: Option | None = getattr(action, "option", None)
        how = None if option is None else _how(option)
        if how is not None:
            action.complete = how  # type: ignore[attr-defined]  # where shtab looks for it
    written = str(shtab.complete(parser, shell))
    return written + BASH_END if shell == "bash" else written


def _how(option: Option) -> Any:
    """How an option is completed; None leaves it to shtab, which knows choices."""
    import shtab

    if option.completes == "folders":
        return shtab.DIRECTORY
    if option.completes in KINDS:
        return _of_kind(option.completes)
    return shtab.FILE if option.type is Path or isinstance(option.type, FileType) else None


def _of_kind(kind: str) -> dict[str, Any]:
    """Names of a kind; and files, where those will do."""
    if kind not in FILES:
        return {
            "bash": f"_bt_mission_{kind}_names",
            "zsh": f"_bt_mission_{kind}",
            "fish": FISH_NAMES.format(kind=kind),
            "preamble": {"bash": BASH_NAMES.format(kind=kind), "zsh": ZSH_NAMES.format(kind=kind)},
        }
    dotted = (*SUFFIXES, *points("mission_file")) if kind in ("missions", "runs") else SUFFIXES
    suffixes = [suffix.removeprefix(".") for suffix in dotted]
    filled = {"kind": kind, "suffixes": " ".join(suffixes), "alternatives": "|".join(suffixes)}
    return {
        "bash": f"_bt_mission_{kind}_file",
        "zsh": f"_bt_mission_{kind}",
        "fish": FISH.format(**filled),
        "preamble": {"bash": BASH.format(**filled), "zsh": ZSH.format(**filled)},
    }


def _actions(action: argparse.Action) -> Iterator[argparse.Action]:
    """Yield all arguments of the commands below an argument; or that itself."""
    if not isinstance(action.choices, dict):
        yield action
        return
    for parser in action.choices.values():
        for inner in parser._actions:  # noqa: SLF001 - argparse has no public way to its arguments
            yield from _actions(inner)


_PLAIN_NAME = re.compile(r"[\w.+@%/-]+(=[\w.+@%/-]*)?", re.ASCII)
"""Names that a shell takes as they are: it expands `$(...)` and blanks in what it completes."""


def known(kind: str, line: str = "") -> list[str]:
    """Return the names of a kind that fit a command line so far; what a shell expands is left out.

    Missing and unreadable files are ignored without a message, since the user is typing.

    Raises:
        KeyError: For a kind that is not in :data:`KINDS`.
    """
    try:
        names = KINDS[kind](_words(line))
    except BtMissionError:
        return []
    return [name for name in names if _PLAIN_NAME.fullmatch(name)]


def _words(line: str) -> list[str]:
    """Split a command line as far as it goes: its last quotes may be open."""
    try:
        return shlex.split(line)
    except ValueError:
        return re.split(r"[\s'\"]+", line)


def _runs(_: list[str]) -> list[str]:
    return [*names("missions"), *scenarios(), *fleets()]


def _listed(_: list[str]) -> list[str]:
    from bt_mission.base.file_index import list_files

    return [mission_file.name for mission_file in list_files("missions")]


def _inputs(words: list[str]) -> list[str]:
    """Name the inputs of the first mission, scenario or fleet of the line."""
    program, *rest = words or [""]
    given = rest if Path(program).name == "bt-mission" else words
    if called(given):  # a shipped mission has the name of a command
        given = given[1:]
    for word in given:
        path = None if word.startswith("-") else look_for("missions", word)
        if path is not None:
            return [
                text
                for name, places in _inputs_of(path).items()
                for text in (f"{name}=", *(f"{name}={place}" for place in places))
            ]
    return []


def _inputs_of(path: Path) -> dict[str, list[str]]:
    """Read the inputs of a mission, or of those of a scenario or a fleet, without checking it.

    Those that hold the name of a place have the names of all places.
    """
    from bt_mission.base.yaml.document import read

    if path.suffix not in SUFFIXES:
        return {}
    kind, data = kind_of(path), _mapping(read(path).data)
    if kind == "scenario":
        return _inputs_of_named(data, path)
    if kind == "fleet":
        inputs: dict[str, list[str]] = {}
        for robot, written in _mapping(data.get("robots")).items():
            for name, values in _inputs_of_named(_mapping(written), path).items():
                inputs |= {name: values, f"{robot}.{name}": values}
        return inputs
    from bt_mission.language.expressions.places import Places
    from bt_mission.language.places import zones_of_file

    zones = zones_of_file(str(data.get("world") or ""), str(path))
    own = {str(name): (0.0, 0.0, 0.0) for name in _mapping(data.get("places"))}
    places = Places(own, lambda: zones)
    return {
        str(name): sorted(places.all) if isinstance(value, str) and places.find(value) else []
        for name, value in _mapping(data.get("inputs")).items()
    }


def _inputs_of_named(written: Mapping[Any, Any], path: Path) -> dict[str, list[str]]:
    """Read the inputs of the mission that another file names."""
    name = str(written.get("mission") or "")
    beside = path.parent / name
    inner = beside if is_file(beside) else look_for("missions", name, path)
    return {} if inner is None or kind_of(inner) != "mission" else _inputs_of(inner)


def _mapping(value: Any) -> Mapping[Any, Any]:
    return value if isinstance(value, dict) else {}


def _codes(_: list[str]) -> list[str]:
    from bt_mission.base.error_catalogue import catalogue

    return [*catalogue()]


def _added(kind: str) -> Callable[[list[str]], list[str]]:
    """Make the lookup of a kind of names that a command adds."""

    def look(words: list[str]) -> list[str]:
        names: list[str] = loaded(points(POINT)[kind])(words)
        return names

    return look


POINT = "completion."
KINDS: Mapping[str, Callable[[list[str]], list[str]]] = {
    "missions": lambda _: names("missions"),
    "runs": _runs,
    "listed": _listed,
    "worlds": lambda _: names("worlds"),
    "robots": lambda _: names("robots"),
    "parameters": lambda _: names("parameters"),
    "inputs": _inputs,
    "codes": _codes,
    **{kind: _added(kind) for kind in points(POINT)},
}
"""What is completed by name; runs are missions, scenarios and fleets, listed all of `missions`."""

FILES = ("missions", "runs", "listed", "worlds", "robots", "parameters")
"""Those for which a file of one's own will do, too."""

COMMANDS = {
    "completion": Command(
        completion,
        "Prints a script with which a shell completes commands, options, files, and the names of "
        "missions, worlds, robots, inputs, topics and other parts of the running graph.",
        (
            Option("shell", "the shell for which to print the script", nargs="?", choices=SHELLS),
            Option(
                "--names",
                "print the known names of this kind instead, one per line",
                choices=tuple(KINDS),
            ),
            Option(
                "--line WORDS",
                "with --names: the command line so far; inputs are those of its mission",
                default="",
            ),
        ),
        EPILOG,
    )
}
