"""The descriptions of entities that can be put into a running simulation."""

from __future__ import annotations

import re
from dataclasses import dataclass
from urllib.parse import unquote

from bt_mission.base.diagnostics import did_you_mean, listed
from bt_mission.base.errors import BtMissionError
from bt_mission.base.files import names
from bt_mission.base.geometry import Pose2D
from bt_mission.base.yaml.document import read_text
from bt_mission.base.yaml.models import validate
from sim.physics.prop_bodies import shape
from sim.world.shapes import Colour, Obstacle
from sim.world.world import Extent, Name, WorldPart

MOST_TEXT = 4000
"""Characters of a description."""


@dataclass(frozen=True)
class SpawnableKind:
    """A shape with a name: its description and its defaults."""

    description: str
    defaults: str


SPAWNABLES = {
    "box": SpawnableKind("a box of 0.3 m x 0.3 m, 0.5 m high", "size: [0.3, 0.3, 0.5]"),
    "cylinder": SpawnableKind("a pillar of 0.15 m radius, 0.5 m high", "radius: 0.15"),
}

EXAMPLE = "box?size=[0.2,0.4,0.3]&colour=red"


class NoResourceError(BtMissionError):
    """There is no description of the entity to spawn."""

    code = "BT-807"


class FormatError(BtMissionError):
    """A description in an unknown format."""

    code = "BT-807"


class RobotsAreFixedError(BtMissionError):
    """A robot was to be spawned: robots are there from the start on."""

    code = "BT-807"


class Spawnable(WorldPart):
    """A box, by its size (m), or an upright cylinder, by radius and height (m)."""

    name: Name | None = None
    size: tuple[Extent, Extent, Extent] | None = None
    radius: Extent | None = None
    height: Extent = 0.5
    colour: Colour = "orange"

    def obstacle(self, name: str, pose: Pose2D) -> Obstacle:
        """Return it as a shape at a pose. Raises PropError."""
        made = shape(name, (pose.x, pose.y, 0.0), self.size, self.radius, self.height, self.colour)
        return made.turned(pose.yaw)


def read_spawnable(uri: str, text: str) -> Spawnable:
    """Read what is to be spawned: `box?size=[0.2,0.4,0.3]&colour=red`, or the same as YAML.

    `text` counts only where there is no URI. Raises NoResourceError, FormatError,
    RobotsAreFixedError, and InputError for what is not understood.
    """
    if not uri and not text.strip():
        raise NoResourceError(f"neither a URI nor a text says what to spawn; try {EXAMPLE}")
    if max(len(uri), len(text)) > MOST_TEXT:
        raise FormatError(f"a description has at most {MOST_TEXT} characters")
    return validate(read_text(_text_of(uri) if uri else _checked(text)), Spawnable)


def _text_of(uri: str) -> str:
    """Return the YAML of a URI."""
    what, _, query = uri.partition("?")
    kind = SPAWNABLES.get(what)
    if kind is None:
        if what in names("robots"):
            raise RobotsAreFixedError(
                f"robot '{what}': robots cannot be added to a running simulation; start it with"
                " bt-mission sim --robots"
            )
        near = did_you_mean(what, SPAWNABLES)
        raise FormatError(
            f"unknown entity '{what}'; known are {listed(SPAWNABLES)}, with values such as"
            f" {EXAMPLE}" + (f"; {near}" if near else "")
        )
    given = [unquote(parameter).partition("=") for parameter in query.split("&") if parameter]
    written = [f"{key}: {value}" for key, _, value in given]
    default = kind.defaults.partition(":")[0]
    if default not in {key for key, _, _ in given}:
        written.append(kind.defaults)
    return "\n".join(written)


def _checked(text: str) -> str:
    """Return a text that may be YAML. Raises FormatError for what is XML, which is not read."""
    if re.match(r"\s*<", text):
        raise FormatError(
            "SDF, URDF and MJCF are not read; write YAML, such as {size: [0.2, 0.4, 0.3]} for a"
            " box, or {radius: 0.1, height: 0.5} for a cylinder (m)"
        )
    return text
