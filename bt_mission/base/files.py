"""The places of missions, worlds, robots and parameters: the user's first, then the shipped."""

from __future__ import annotations

import errno
import glob
import os
import re
import stat
import sys
from io import TextIOWrapper
from pathlib import Path
from typing import BinaryIO, Literal

from bt_mission.base.diagnostics import Diagnostic, InputError, did_you_mean, listed

Kind = Literal["missions", "worlds", "robots", "parameters"]

SUFFIXES = (".yaml", ".yml")
MOST_READ = 1_000_000
"""Characters of a file that are searched for its kind; larger files are refused."""
FileKind = Literal["mission", "scenario", "fleet", "world", "robot", "requirements", "ranges"]
_TOP_KEY = re.compile(r"^([a-z_]+)[ ]*:", re.MULTILINE)
_KEYS: dict[FileKind, frozenset[str]] = {
    "scenario": frozenset(("scenario",)),
    "fleet": frozenset(("fleet",)),
    "mission": frozenset(("mission", "tree", "trees", "include")),
    "robot": frozenset(("drive", "lidar", "body", "base_mass", "base_inertia")),
    "world": frozenset(("size", "walls", "boxes", "cylinders", "zones", "spawn", "slippery")),
    "requirements": frozenset(("requirements",)),
    "ranges": frozenset(("seeds", "worlds", "robots", "plans", "obstacles", "faults", "assume")),
}
"""Keys at the top of a file by which its kind is known, in the order in which they count."""
_PLAIN_WORDS = re.compile(
    r"^(mission|scenario|fleet|world)[ ]*:[ ]+([\w.-]+(?: [\w.-]+)*)[ ]*(?:#.*)?$",
    re.MULTILINE | re.ASCII,
)
_SOURCE = Path(__file__).resolve().parent.parent.parent
_IS_INSTALLED = _SOURCE.name in ("site-packages", "dist-packages")


def find(kind: Kind, name_or_path: str | Path, near: str | Path | None = None) -> Path:
    """Return the file of a mission, world or robot, or of parameters.

    Looked for, in this order: the path as it is; next to `near` (a file or a folder);
    `./KIND/NAME.yaml`; the source checkout; `PREFIX/share/bt_mission/KIND` of each prefix. A
    shipped file is also found by its path in the checkout, such as ``missions/square.yaml``.
    Raises InputError with the names that are known.
    """
    path = look_for(kind, name_or_path, near)
    if path is not None:
        return path
    wanted = str(name_or_path)
    known = names(kind)
    what = "parameter file" if kind == "parameters" else kind.removesuffix("s")
    message = f"no such {what} (known: {listed(known)})"
    hint = other_suffix(kind, Path(wanted)) or did_you_mean(Path(wanted).stem, known)
    raise InputError([Diagnostic("BT-110", message, wanted, hint=hint)])


def look_for(kind: Kind, name_or_path: str | Path, near: str | Path | None = None) -> Path | None:
    """Return the same as `find`, or None."""
    wanted = Path(name_or_path)
    if not wanted.name or "\0" in str(wanted):
        return None
    beside = [] if near is None else [_folder(Path(near)), _folder(Path(near)).parent / kind]
    is_path = wanted.suffix in SUFFIXES or len(wanted.parts) > 1
    if is_path:
        candidates = [wanted, *(folder / wanted for folder in beside[:1])]
        inside = wanted.relative_to(kind) if wanted.parts[0] == kind else wanted
        candidates += [folder / tail for folder in folders(kind) for tail in (wanted, inside)]
    else:
        candidates = [
            folder / f"{wanted}{suffix}"
            for folder in [*beside, *folders(kind)]
            for suffix in SUFFIXES
        ]
    return next((path for path in candidates if is_file(path)), None)


def other_suffix(kind: Kind, path: Path) -> str | None:
    """Return a hint at a file of the same name with the other suffix of YAML, or None."""
    if path.suffix not in SUFFIXES:
        return None
    for suffix in SUFFIXES:
        other = path.with_suffix(suffix)
        if suffix != path.suffix and look_for(kind, other):
            return f"did you mean '{other}'?"
    return None


def look_deeper(kind: Kind, name: str) -> Path | None:
    """Return the file of this name one folder deeper, such as that of a scenario, or None."""
    return next(
        (
            path
            for folder in folders(kind)
            for path in sorted(folder.glob(f"*/{glob.escape(name)}.*"))
            if path.suffix in SUFFIXES and path.name.split(".")[0] == name
        ),
        None,
    )


def names(kind: Kind) -> list[str]:
    """Return the names of the missions, worlds or robots that are there, sorted."""
    return sorted(
        {
            path.stem
            for folder in folders(kind)
            if folder.is_dir()
            for path in folder.iterdir()
            if path.suffix in SUFFIXES and not path.stem.endswith((".scenario", ".fleet"))
        }
    )


def scenarios() -> list[str]:
    """Return the scenarios that are shipped, as `run` takes them, sorted."""
    paths_by_folder = (folder.glob("scenarios/*.scenario.yaml") for folder in folders("missions"))
    return sorted({f"scenarios/{path.name}" for paths in paths_by_folder for path in paths})


def fleets() -> list[str]:
    """Return the fleets that are shipped, as `run` takes them, sorted."""
    paths_by_folder = (folder.glob("fleets/*.fleet.yaml") for folder in folders("missions"))
    return sorted({f"fleets/{path.name}" for paths in paths_by_folder for path in paths})


def folders(kind: Kind) -> list[Path]:
    """Return where files of a kind lie: in the working folder, the sources, what is installed."""
    return [Path(kind), *shipped_folders(kind)]


def shipped_folders(kind: Kind) -> list[Path]:
    """Return where the shipped files of a kind lie: in the sources, or where they are installed."""
    return [_SOURCE / kind, *(prefix / "share" / "bt_mission" / kind for prefix in prefixes())]


def prefixes() -> list[Path]:
    """Return the prefixes of installed packages: those of a sourced ROS, then Python's.

    Python's are the prefixes of `pip install --user`, Debian's pip, and the environment.
    """
    sourced = filter(None, os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep))
    own = list(_SOURCE.parents[2:3]) if _IS_INSTALLED else []
    return list(dict.fromkeys([*map(Path, sourced), *own, Path(sys.prefix)]))


def docs_folder() -> Path | None:
    """Return the folder of the documentation's pages; None if they are not installed."""
    folders = [prefix / "share" / "bt_mission" / "docs" for prefix in prefixes()]
    if not _IS_INSTALLED:  # other packages may have created such a folder beside an installed one
        folders.insert(0, _SOURCE / "docs")
    return next((folder for folder in folders if is_file(folder / "README.md")), None)


def _folder(near: Path) -> Path:
    return near if near.is_dir() else near.parent


def is_file(path: Path) -> bool:
    """Return whether a file exists; a name that is too long does not."""
    try:
        return path.is_file()
    except (OSError, ValueError):  # a name that is too long, or a folder that may not be read
        return False


def open_file(path: str | Path, *, follows: bool = True) -> BinaryIO:
    """Open a file of the user to read it. Pipes, devices and folders are refused without waiting.

    Args:
        path: Its path.
        follows: Whether it may be a symbolic link.

    Raises:
        OSError: There is no such file, it cannot be read, or it is a folder, a device or a pipe.
    """
    flags = os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC | (0 if follows else os.O_NOFOLLOW)
    _refuse_other_than_file(os.stat(path, follow_symlinks=follows).st_mode, path)  # noqa: PTH116
    number = os.open(path, flags)
    try:
        _refuse_other_than_file(os.fstat(number).st_mode, path)  # it may be another one by now
    except OSError:
        os.close(number)
        raise
    return os.fdopen(number, "rb")


def _refuse_other_than_file(mode: int, path: str | Path) -> None:
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, "expected a file, got a folder", str(path))
    if not stat.S_ISREG(mode):
        raise OSError(errno.EINVAL, "expected a file, got a device or pipe", str(path))


def contents_of(path: str | Path) -> bytes:
    """Return all of a file. Raises OSError as `open_file` does."""
    with open_file(path) as stream:
        return stream.read()


def kind_of(path: str | Path) -> FileKind:
    """Return the kind of a file, by its top-level keys; a mission by default."""
    return kind_of_text(text_to_look_at(path))


def kind_of_text(text: str) -> FileKind:
    """Return the kind of the text of a file; a mission by default."""
    return known_kind_of_text(text) or "mission"


def known_kind_of_text(text: str) -> FileKind | None:
    """Return the kind of the text of a file; None without a key of any."""
    keys = top_keys(text)
    return next((kind for kind, known in _KEYS.items() if keys & known), None)


def top_keys(text: str) -> frozenset[str]:
    """Return the keys at the top of a YAML text, as a first look finds them."""
    return frozenset(_TOP_KEY.findall(text))


def is_scenario(path: str | Path) -> bool:
    """Return whether a file is a scenario rather than a mission."""
    return kind_of(path) == "scenario"


def plain_words(path: str | Path) -> dict[str, str]:
    """Return the values of `mission`, `scenario`, `fleet` and `world` in a YAML file.

    Only those that are plain words. It is only for messages before the file is read completely,
    which takes a while.
    """
    return dict(_PLAIN_WORDS.findall(text_to_look_at(path)))


def text_to_look_at(path: str | Path) -> str:
    """Return the beginning of a YAML file, or nothing; a pipe is not read."""
    file = Path(path)
    if file.suffix not in SUFFIXES or not is_file(file):
        return ""
    try:
        with TextIOWrapper(open_file(file), encoding="utf-8", errors="replace") as opened:
            return opened.read(MOST_READ)
    except OSError:
        return ""
