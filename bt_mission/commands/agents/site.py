"""The file of a site: what the missions of agents may use, and what they must hold."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field

from bt_mission.base.actions import declared
from bt_mission.base.diagnostics import Diagnostic, InputError, in_order, listed, quoted
from bt_mission.base.errors import BtMissionError
from bt_mission.base.files import Kind, find
from bt_mission.base.nature import Profile
from bt_mission.base.yaml.document import Document, Key, read_source, read_text
from bt_mission.commands.agents.folder import Proposal, digest_of
from bt_mission.commands.agents.names import why_invalid
from bt_mission.commands.agents.site_files import SiteFiles, differing
from bt_mission.language.loader import Examined
from bt_mission.language.mission import Mission, Requirement
from bt_mission.language.node_reader import NodeReader
from bt_mission.language.nodes import fields
from bt_mission.language.nodes.action import GoalNode
from bt_mission.language.nodes.base import NodeModel, Written
from bt_mission.language.nodes.composites import FinallyNode
from bt_mission.language.nodes.interfaces import PublishNode, ServiceNode, WaitForNode
from bt_mission.language.permissions import Permissions
from bt_mission.requirements.checks import RequirementNames, diagnostics_of_names
from bt_mission.requirements.language.formula import root_of, signals_in
from bt_mission.requirements.language.signals import SIGNALS
from bt_mission.requirements.language.written import Requirements, requirements_of
from bt_mission.robots.model import RobotModel, load_robot
from bt_mission.sessions.check import WorldAndRobot, examine
from sim.world.loader import load_world
from sim.world.world import World


class SiteChangedError(BtMissionError):
    """A file of a site that differs from what a running program has read of it."""

    code = "BT-1410"


ALONE = Permissions(
    folders=(),
    includes=False,
    python="refuse",
    hint="the mission of an agent is one text, without files or Python code",
)


class SiteFile(Written):
    """The whole file. Times are seconds."""

    site: fields.Line
    description: str = ""
    namespace: str = ""
    robot: fields.Line = "waffle"
    world: fields.Line
    nature: Profile = "usual"
    requirements: Annotated[Requirements, Field(min_length=1)]
    actions: list[fields.Line] | None = None
    topics: list[fields.Line] = []
    seeds: Annotated[int, Field(ge=1, le=1000)] = 20
    faults: dict[fields.Line, list[str]] = {}
    limit: Annotated[float, Field(gt=0, le=100_000)] = 600.0
    expires: Annotated[float, Field(gt=0, le=86_400)] = 600.0
    approvers: list[fields.Line] = []


@dataclass(frozen=True)
class Site:
    """A site, read.

    Attributes:
        requirements: Those that every mission of an agent must hold; a violation halts it.
        actions: The names of the actions that missions may use.
        written: The file.
        files: The bytes of it, of its robot and of its world, from which everything here follows.
    """

    file: Path
    written: SiteFile
    files: SiteFiles
    world: World
    robot: RobotModel
    requirements: tuple[Requirement, ...]
    actions: tuple[str, ...]

    @property
    def digest(self) -> str:
        """Changes with each file of the site, and with the program."""
        return digest_of(dict(self.files.digests))

    @property
    def name(self) -> str:
        """The name of the site."""
        return self.written.site

    def seeds(self, proposal: Proposal) -> tuple[int, ...]:
        """Return the seeds of the runs that are evidence: those of the site, and the drive's."""
        own = range(self.written.seeds)
        return tuple(own) if proposal.seed in own else (*own, proposal.seed)

    def runs(self, proposal: Proposal) -> int:
        """Return the number of simulated runs that are evidence."""
        return len(self.seeds(proposal)) * len(self.plans)

    def refuse_changed(self) -> None:
        """Raise SiteChangedError if a file on the disk is not the one that was read."""
        try:
            now = load_site(self.file).files.digests
        except BtMissionError as error:
            raise SiteChangedError(f"{self.file}: {error.headline}") from None
        if changed := differing(self.files.digests, now):
            raise SiteChangedError(
                f"{changed} has changed since this program has read it: start it again"
            )

    @property
    def plans(self) -> dict[str, list[str]]:
        """The faults of simulated runs, by the names of their plans."""
        return {"none": [], **self.written.faults}

    @property
    def only_simulated(self) -> frozenset[str]:
        """Names of requirements with signals that no robot measures: they halt nothing there."""
        return frozenset(
            each.name
            for each in self.requirements
            for signal in signals_in(root_of(each))
            if SIGNALS[signal.name].known_by == "simulator"
        )

    def requirements_file(self) -> dict[str, Any]:
        """Return the requirements as a file has them."""
        return {
            "requirements": {
                each.name: {"formula": each.text, "on_violation": each.on_violation}
                for each in self.requirements
            }
        }

    def examine(self, proposal: Proposal) -> Examined:
        """Check a proposal as a mission of this site: its robot, its world, its actions.

        Returns:
            The mission with the requirements of the site, and all warnings; or None, with every
            error and warning.
        """
        try:
            document = read_text(proposal.text, f"{proposal.name}.yaml")
        except InputError as error:
            return None, error.diagnostics
        mission, diagnostics = examine(
            document,
            proposal.inputs,
            proposal.seed,
            world=str(self.path("worlds", self.written.world)),
            robot=str(self.path("robots", self.written.robot)),
            permissions=replace(ALONE, folders=(self.file.parent.absolute(),)),
            given=WorldAndRobot(self.world, self.robot),
        )
        refused = list(self._head(document))
        if mission is not None:
            refused += [*self._nodes(mission), *_names(mission)]
        if mission is None or refused:
            return None, in_order((*diagnostics, *refused))
        requirements = (*mission.requirements, *self.requirements)
        return replace(mission, requirements=requirements), diagnostics

    def path(self, kind: Kind, name: str) -> Path:
        """Return the file of its robot or world."""
        return find(kind, name, self.file).absolute()

    def _head(self, document: Document) -> Iterator[Diagnostic]:
        """Yield what the head of a mission may not decide."""
        data = document.data if isinstance(document.data, dict) else {}
        for key, own in (("robot", self.written.robot), ("world", self.written.world)):
            if key in data and data[key] != own:
                message = f"the {key} of this site is {quoted(own)}, got {quoted(str(data[key]))}"
                yield document.diagnostic("BT-1402", (key,), message, "leave the key out")
        written = data.get("requirements")
        for name in written if isinstance(written, dict) else ():
            if any(each.name == name for each in self.requirements):
                message = f"the requirement {quoted(str(name))} is one of the site"
                hint = "the site's requirements hold for every mission; choose another name"
                place = ("requirements", name)
                yield document.diagnostic("BT-1402", place, message, hint, key=True)
        if "nodes" in data:
            message = "a mission of an agent starts no nodes"
            yield document.diagnostic("BT-1402", ("nodes",), message, key=True)

    def _nodes(self, mission: Mission) -> Iterator[Diagnostic]:
        """Yield the topics and nodes that the missions of this site may not have."""
        for each in mission.requirements:
            for topic in _topics_of(each):
                if why := self._no_topic(topic):
                    place = ("requirements", each.name)
                    yield mission.document.diagnostic("BT-1402", place, *why)
        for tree in mission.all_trees:
            for follow in tree.follow:
                if why := self._no_topic(follow.settings.topic):
                    path = (*tree.path[:-1], "follow")
                    yield tree.document.diagnostic("BT-1402", path, *why)
            for node in tree.body.walk():
                if why := self._refused(node):
                    yield tree.document.diagnostic("BT-1402", node.path, *why)

    def _refused(self, node: NodeModel) -> tuple[str, str | None] | None:
        match node:
            case GoalNode() if node.ros_name not in self.actions:
                known = listed(self.actions)
                return f"this site does not offer {node.ros_name} (it offers: {known})", None
            case WaitForNode():
                return self._no_topic(node.ros_name)
            case FinallyNode():
                return "a mission of an agent has no clean-up, which would run after a halt", None
            case PublishNode() | ServiceNode():
                return "a mission of an agent sends goals only: no messages or requests", None
            case _:
                return None

    def _no_topic(self, topic: str) -> tuple[str, str | None] | None:
        if topic in self.written.topics:
            return None
        known = listed(self.written.topics)
        return f"this site does not offer the topic {topic} (it offers: {known})", None


def _names(mission: Mission) -> Iterator[Diagnostic]:
    """Yield names that a person could take for something else."""
    document = mission.document
    named: list[tuple[Document, tuple[Key, ...], str]] = [(document, ("mission",), mission.name)]
    for key, names in (
        ("inputs", mission.inputs),
        ("places", mission.places),
        ("requirements", [each.name for each in mission.requirements]),
        ("trees", mission.trees),
    ):
        named += [(document, (key, name), name) for name in names]
    for tree in mission.all_trees:
        named += [(tree.document, (*node.path, "name"), node.name) for node in tree.body.walk()]
    for where, path, name in named:
        if why := why_invalid(name):
            yield where.diagnostic("BT-1402", path, why, key=path[0] != "mission")


def _topics_of(requirement: Requirement) -> Iterator[str]:
    """Yield the topics that a requirement names."""
    for signal in signals_in(root_of(requirement)):
        known = SIGNALS.get(signal.name)
        if known is not None and "topic" in known.arguments:
            yield signal.arguments[known.arguments.index("topic")]


def seed_of(text: str) -> int:
    """Return the seed in the text of a mission; 0 without a valid one."""
    try:
        data = read_text(text).data
    except InputError:
        return 0
    seed = data.get("seed") if isinstance(data, dict) else None
    return seed if type(seed) is int and 0 <= seed < 2**63 else 0


def load_site(path: Path) -> Site:
    """Return the site of a file.

    Raises:
        InputError: With every error of it.
    """
    text = read_source(path)
    document = read_text(text, str(path))
    reader = NodeReader(document)
    written = reader.written(SiteFile, (), document.data)
    # Without nodes and variables: those are the mission's, which must not decide on a requirement.
    names = diagnostics_of_names(document, RequirementNames(nodes={}, variables=()))
    diagnostics = [*reader.diagnostics, *names]
    known = tuple(sorted(declared()))
    actions = written.actions if written is not None else None
    for number, name in enumerate(actions or ()):
        if name not in known:
            message = f"unknown action {quoted(name)} (known: {listed(known)})"
            diagnostics.append(document.diagnostic("BT-110", ("actions", number), message))
    if written is None or diagnostics:
        raise InputError(in_order(diagnostics))
    files = SiteFiles.read(path, text, written.world, written.robot)
    return Site(
        file=path,
        written=written,
        files=files,
        world=load_world(files.world),
        robot=load_robot(files.robot),
        requirements=tuple(
            replace(each, on_violation="halt") for each in requirements_of(written.requirements)
        ),
        actions=known if actions is None else tuple(actions),
    )
