"""Nature: harmless differences from one run to the next in the real world.

One table declares every quantity. A profile draws each of them from the seed, by a generator with
the quantity's name; a number in place of a draw fixes it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, get_args

if TYPE_CHECKING:
    import random

Profile: TypeAlias = Literal["none", "mild", "usual", "harsh"]
PROFILES: tuple[Profile, ...] = get_args(Profile)

Shape: TypeAlias = Literal["normal", "up to", "down to"]
"""How a quantity is drawn of the value of its profile: ``normal`` about 0, with the value for one
standard deviation, and again beyond two of them; ``up to``, evenly from 0 to the value; ``down
to``, evenly from the value to 1."""

_DIGITS = 6
_MOST_DEVIATION = 2.0


@dataclass(frozen=True)
class NatureQuantity:
    """A quantity that differs from run to run.

    Attributes:
        unit: Of its values; empty for a plain number.
        shape: The distribution of its draws.
        mild: The value of that profile, from which it is drawn. The other profiles have one, too.
        neutral: Its value without a draw.
        least: The smallest number that can be set.
        most: The greatest.
        text: What it is.
        source: Where its values come from.
    """

    name: str
    unit: str
    shape: Shape
    mild: float
    usual: float
    harsh: float
    least: float
    most: float
    text: str
    source: str
    neutral: float = 0.0

    def drawn(self, profile: Profile, generator: random.Random) -> float:
        """Return a value of a profile, of six digits."""
        if profile == "none":
            return self.neutral
        scale: float = getattr(self, profile)
        match self.shape:
            case "normal":
                deviation = generator.gauss()
                while abs(deviation) > _MOST_DEVIATION:
                    deviation = generator.gauss()
                value = scale * deviation
            case "up to":
                value = scale * generator.random()
            case "down to":
                value = scale + (1 - scale) * generator.random()
        return float(f"{value:.{_DIGITS}g}")


_PLACED = "a robot placed by hand on a mark (an assumption)"
_LDS = "LDS-01: accuracy 15 mm below 0.5 m, precision 10 mm (ROBOTIS e-manual)"
_AMCL = "mean error of 6.7 cm (Schmitt and others, IPIN 2012)"
_JUMPS = "a particle filter in symmetric surroundings (an assumption)"
_WIRELESS = "a robot and its servers on one wireless network (an assumption)"

QUANTITIES: tuple[NatureQuantity, ...] = (
    NatureQuantity(
        "start_x",
        "m",
        "normal",
        *(0.01, 0.03, 0.06),
        *(-1.0, 1.0),
        "offset of the start along the map's x",
        _PLACED,
    ),
    NatureQuantity(
        "start_y",
        "m",
        "normal",
        *(0.01, 0.03, 0.06),
        *(-1.0, 1.0),
        "offset of the start along the map's y",
        _PLACED,
    ),
    NatureQuantity(
        "start_yaw",
        "deg",
        "normal",
        *(1.0, 3.0, 8.0),
        *(-180.0, 180.0),
        "offset of the heading at the start",
        _PLACED,
    ),
    NatureQuantity(
        "localization_error",
        "m",
        "up to",
        *(0.02, 0.05, 0.1),
        *(0.0, 1.0),
        "standard deviation of the localization along x and y; it changes with each update",
        _AMCL,
    ),
    NatureQuantity(
        "localization_yaw_error",
        "deg",
        "up to",
        *(0.5, 2.0, 5.0),
        *(0.0, 90.0),
        "standard deviation of the localization's heading",
        "0.05 m over the 1.5 m to the walls of a small arena (derived)",
    ),
    NatureQuantity(
        "localization_jumps",
        "1/min",
        "up to",
        *(0.0, 0.5, 2.0),
        *(0.0, 60.0),
        "how often the localization jumps, while the robot moves",
        _JUMPS,
    ),
    NatureQuantity(
        "localization_jump",
        "m",
        "up to",
        *(0.0, 0.15, 0.4),
        *(0.0, 5.0),
        "length of such a jump; later updates reduce it",
        _JUMPS,
    ),
    NatureQuantity(
        "wheel_radius",
        "%",
        "normal",
        *(0.3, 1.0, 2.0),
        *(-50.0, 50.0),
        "by how much odometry assumes larger wheels",
        "0.3 mm of 33 mm: wear and dirt (an assumption)",
    ),
    NatureQuantity(
        "wheel_difference",
        "%",
        "normal",
        *(0.05, 0.1, 0.3),
        *(-20.0, 20.0),
        "by how much odometry assumes a larger left wheel",
        "less than of the radius: the IMU corrects the heading (an assumption)",
    ),
    NatureQuantity(
        "wheel_grip",
        "",
        "down to",
        *(0.8, 0.5, 0.3),
        *(0.0, 1.0),
        "coefficient of friction between wheels and floor",
        "rubber on a dry floor 1 to 0.5, on a dusty one 0.3 (an assumption)",
        1.0,
    ),
    NatureQuantity(
        "lidar_noise",
        "m",
        "up to",
        *(0.005, 0.01, 0.03),
        *(0.0, 1.0),
        "standard deviation of additional noise on each distance",
        _LDS,
    ),
    NatureQuantity(
        "lidar_bias",
        "m",
        "normal",
        *(0.003, 0.0075, 0.015),
        *(-1.0, 1.0),
        "error of all distances alike",
        _LDS,
    ),
    NatureQuantity(
        "lidar_dropout",
        "%",
        "up to",
        *(0.5, 2.0, 10.0),
        *(0.0, 100.0),
        "share of rays without a reading, drawn for each scan",
        "1 % of an LDS-02, more on dark surfaces (an assumption)",
    ),
    NatureQuantity(
        "topic_latency",
        "s",
        "up to",
        *(0.005, 0.02, 0.05),
        *(0.0, 2.0),
        "mean delay of sensors, transforms and commands; of each message 0.5 to 1.5 times this",
        _WIRELESS,
    ),
    NatureQuantity(
        "server_latency",
        "s",
        "up to",
        *(0.01, 0.05, 0.15),
        *(0.0, 10.0),
        "the same of goals, cancel requests, results and feedback",
        _WIRELESS,
    ),
)
"""Every quantity, in the order in which they are shown."""

BY_NAME: Mapping[str, NatureQuantity] = {quantity.name: quantity for quantity in QUANTITIES}


@dataclass(frozen=True)
class Nature:
    """A profile, with numbers in place of draws.

    Attributes:
        set: Values by the names of quantities, in their units.
    """

    profile: Profile = "none"
    set: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))

    def drawn(self, seed: int, robot: str = "") -> dict[str, float]:
        """Return the value of each quantity in a run; empty if nothing is drawn or set.

        Args:
            robot: The name of one of several robots, each of which has separate draws.
        """
        if self.profile == "none" and not self.set:
            return {}
        return {
            quantity.name: self.set[quantity.name]
            if quantity.name in self.set
            else quantity.drawn(self.profile, generator(seed, quantity.name, robot))
            for quantity in QUANTITIES
        }

    @property
    def written(self) -> str | dict[str, Any]:
        """The form in a file."""
        return {"profile": self.profile, **self.set} if self.set else self.profile


NO_NATURE = Nature()
USUAL = Nature("usual")


def generator(seed: int, name: str, robot: str = "") -> random.Random:
    """Return the generator of a name, the same in every run of a seed."""
    import random  # noqa: PLC0415 - options name natures without drawing any

    return random.Random(f"{seed}/nature/{robot}/{name}")


def in_words(values: Mapping[str, float]) -> str:
    """Return drawn values in a line, with their units."""
    units = {name: quantity.unit for name, quantity in BY_NAME.items()}
    parts = (f"{name} {value:g} {units.get(name, '')}" for name, value in values.items())
    return ", ".join(part.rstrip() for part in parts)
