"""All that runs follow from: files, as texts for other machines, and the versions of programs."""

from __future__ import annotations

import hashlib
import json
from base64 import b64decode, b64encode
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache, cached_property
from pathlib import Path

import action_servers
import bt_mission
import sim
from bt_mission.base.errors import BtMissionError
from bt_mission.base.file_index import files_of
from bt_mission.base.files import contents_of, find, folders
from bt_mission.base.output import make_folder_of, within, write_file
from bt_mission.base.user_files import files_beside
from bt_mission.base.versions import versions
from bt_mission.language.mission import Mission, NodeFactory
from bt_mission.language.nodes.leaves import PythonNode
from bt_mission.language.plugins import parts_of
from bt_mission.language.trees import all_steps

MISSION_FOLDER, SHIPPED = "missions", "shipped"
"""The folder of the mission in the bundle; worlds and robots have folders beside it."""

FINGERPRINT_DIGITS = 12


@dataclass(frozen=True)
class Bundle:
    """Files by their paths in a separate folder.

    Attributes:
        files: The text of each file by its path, with ``/`` between folders.
        mission: The path of the mission's file.
        worlds: The name of each world in the bundle, by the user's name or path; robots: those of
            robots.
        folder: The mission's folder, as the user has written it; messages name its files so.
        assets: The content of other files in base64, in the same way: MuJoCo models and meshes.
    """

    files: Mapping[str, str]
    mission: str
    worlds: Mapping[str, str]
    robots: Mapping[str, str]
    folder: str = ""
    assets: Mapping[str, str] = field(default_factory=dict)

    @cached_property
    def digest(self) -> str:
        """SHA-256 of all files with their paths, as hexadecimal digits."""
        files = sorted((*self.files.items(), *self.assets.items()))
        content = json.dumps([self.mission, files], ensure_ascii=False)
        return hashlib.sha256(content.encode()).hexdigest()

    def write_to(self, folder: Path) -> None:
        """Write all files into a folder.

        Raises:
            BtMissionError: When they cannot be written.
        """
        contents: dict[str, str | bytes] = dict(self.files)
        contents |= {name: b64decode(content) for name, content in self.assets.items()}
        for name, content in contents.items():
            path = within(folder, name)
            make_folder_of(path)
            write_file(path, content)


def bundle_of(
    mission: Mission,
    worlds: Iterable[str] = (),
    robots: Iterable[str] = (),
    simulator: NodeFactory | None = None,
) -> Bundle:
    """Read all files of a mission, with its worlds and robots.

    Args:
        worlds: Names or paths, besides the mission's own.
        robots: Names or paths, besides the mission's own.
        simulator: What moves the robot, besides MuJoCo.

    Raises:
        InputError: A world or a robot does not exist.
        BtMissionError: A file cannot be read.
    """
    folder = Path(mission.file).resolve().parent
    files: dict[str, str] = {}
    assets: dict[str, str] = {}
    for document in mission.documents:
        path = Path(document.file).resolve()
        # An included file is below the mission, or shipped: then each machine has it, and this text
        # is only compared.
        is_below = path.is_relative_to(folder)
        name = path.relative_to(folder).as_posix() if is_below else f"{SHIPPED}/{path.name}"
        files[f"{MISSION_FOLDER}/{name}"] = document.text
    for path, name in python_files(mission, simulator):
        text = _read(path)
        if files.setdefault(f"{MISSION_FOLDER}/{name}", text) != text:
            message = f"{path}: mission and scenario use different files named {name}; rename one"
            raise BtMissionError(message, code="BT-208")
    known: dict[str, dict[str, str]] = {"worlds": {}, "robots": {}}
    wanted_worlds = {*worlds, *([mission.world] if mission.world else [])}
    for kind, wanted in (("worlds", wanted_worlds), ("robots", {*robots, mission.robot})):
        taken: dict[str, Path] = {}
        for given in sorted(wanted):
            path = find("worlds" if kind == "worlds" else "robots", given, near=mission.file)
            name = next(
                name
                for name in (path.stem, *(f"{path.stem}_{n}" for n in range(2, len(wanted) + 2)))
                if taken.setdefault(name, path) == path
            )
            known[kind][given] = name
            files[f"{kind}/{name}.yaml"] = _read(path)
            if kind == "robots":
                assets |= _model_files(path, files, assets)
    main = f"{MISSION_FOLDER}/{Path(mission.file).name}"
    written = str(Path(mission.file).parent)
    return Bundle(files, main, known["worlds"], known["robots"], written, assets)


def _model_files(
    robot: Path, files: Mapping[str, str], others: Mapping[str, str]
) -> dict[str, str]:
    """Return the files of a robot's MuJoCo model by their paths beside it, in base64."""
    model = {}
    for path in files_of(robot)[1:]:
        name = f"robots/{path.relative_to(robot.parent).as_posix()}"
        model[name] = b64encode(_read_bytes(path)).decode()
        if name in files or others.get(name, model[name]) != model[name]:
            message = f"{path}: two robots use different files named {name}; rename one"
            raise BtMissionError(message, code="BT-208")
    return model


def python_files(
    mission: Mission, simulator: NodeFactory | None = None
) -> Iterator[tuple[Path, str]]:
    """Yield the Python files of leaves and nodes, each with the name by which it is written.

    With those beside them that they import.

    Modules and plug-ins are installed.
    """
    leaves = [step.target for step in all_steps(mission) if isinstance(step, PythonNode)]
    written = [(mission.file, leaf) for leaf in leaves]
    written += [(node.file, node.target) for node in mission.nodes]
    if simulator is not None:
        written.append((simulator.file, simulator.target))
    for file, target in written:
        name, _ = parts_of(target)
        if name.endswith(".py"):
            path = Path(file).resolve().parent / name
            yield path, name
            for other in files_beside(path):
                yield other, Path(name).parent.joinpath(other.relative_to(path.parent)).as_posix()


def _read(path: Path) -> str:
    try:
        return _read_bytes(path).decode()
    except UnicodeDecodeError as error:
        raise BtMissionError(f"cannot read {path}: {error}", code="BT-101") from error


def _read_bytes(path: Path) -> bytes:
    try:
        return contents_of(path)
    except OSError as error:
        raise BtMissionError(f"cannot read {path}: {error}", code="BT-101") from error


@cache
def fingerprint() -> str:
    """Return the first digits of a SHA-256 of all versions, our sources and shipped missions.

    Versions alone are not enough if a worker runs a checkout.
    """
    digest = hashlib.sha256(json.dumps(versions(), sort_keys=True).encode())
    for package in (bt_mission, action_servers, sim):
        root = Path(str(package.__file__)).parent
        for path in sorted(root.rglob("*.py")):
            digest.update(f"{root.name}/{path.relative_to(root).as_posix()}\n".encode())
            digest.update(path.read_bytes())
    # A mission may include shipped trees; worlds and robots are part of each sweep.
    shipped = {
        path.name: path for folder in folders("missions")[1:] for path in folder.glob("*.y*ml")
    }
    for name, path in sorted(shipped.items()):
        digest.update(f"{name}\n".encode() + path.read_bytes())
    return digest.hexdigest()[:FINGERPRINT_DIGITS]


def versions_in_words() -> str:
    """Return all versions in a line for people."""
    return ", ".join(f"{name} {version}" for name, version in versions().items())
