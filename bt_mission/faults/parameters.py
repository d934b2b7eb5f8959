"""The types of a fault's arguments: numbers with their units, and names of what is in the graph."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal


@dataclass(frozen=True)
class ParameterUnit:
    """The unit of a number that a fault takes."""

    unit: str


Kind = Literal["topic", "action", "service", "node", "leaf"]


@dataclass(frozen=True)
class Named:
    """What a text names, of the things that are there when the fault begins."""

    kind: Kind


@dataclass(frozen=True)
class OneOf:
    """The texts that an argument can be."""

    names: tuple[str, ...]


Seconds = Annotated[float, ParameterUnit("s")]
Metres = Annotated[float, ParameterUnit("m")]
Degrees = Annotated[float, ParameterUnit("deg")]
MetresPerSecond = Annotated[float, ParameterUnit("m/s")]
DegreesPerSecond = Annotated[float, ParameterUnit("deg/s")]
RadiansPerSecond = Annotated[float, ParameterUnit("rad/s")]
Newtons = Annotated[float, ParameterUnit("N")]
NewtonMetres = Annotated[float, ParameterUnit("Nm")]

TopicName = Annotated[str, Named("topic")]
ActionText = Annotated[str, Named("action")]
ServiceName = Annotated[str, Named("service")]
NodeName = Annotated[str, Named("node")]
LeafName = Annotated[str, Named("leaf")]

Place = tuple[Metres, Metres]
"""X and y in the map."""
