"""The form of a fleet file, and its JSON Schema for editors."""

from typing import Annotated, Any

from pydantic import Field

from bt_mission.language.nodes import fields
from bt_mission.language.nodes.base import Written
from bt_mission.language.schema import DIALECT
from bt_mission.scenarios.file import NameOrMapping, StartForm

Seed = Annotated[int, Field(ge=0, lt=2**63)]


class FleetRobotForm(Written):
    """One robot: its mission and its start."""

    mission: NameOrMapping
    robot: fields.Line | None = None
    start: StartForm | None = None
    inputs: dict[fields.Variable, fields.InputValue] = {}
    seed: Seed | None = None


class FleetFile(Written):
    """The whole file."""

    fleet: fields.Line
    description: str = ""
    world: NameOrMapping | None = None
    seed: Seed = 0
    observe: fields.Observe | None = None
    nodes: fields.NodeFactories = []
    robots: dict[str, FleetRobotForm]


def fleet_schema() -> dict[str, Any]:
    """Return the schema of a fleet file."""
    schema = FleetFile.model_json_schema()
    return {"$schema": DIALECT, **schema, "title": "bt-mission fleet"}
