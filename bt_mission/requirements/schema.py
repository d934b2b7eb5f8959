"""The JSON Schema of mission files, with their requirements."""

from __future__ import annotations

from functools import partial

from bt_mission.language import schema
from bt_mission.requirements.language.written import Requirements

mission_schema = partial(schema.mission_schema, {"requirements": Requirements})
"""`bt_mission.language.schema.mission_schema`, with requirements."""
