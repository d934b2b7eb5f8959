"""Texts with which a new file can begin."""

from __future__ import annotations

from collections.abc import Mapping

NEW_FILES: Mapping[str, str] = {
    "Mission": """\
mission: untitled
world: empty_arena
tree:
  sequence:
    - move: {secs: 2}
      timeout: 10
""",
    "Subtrees": """\
trees:
  look_around:
    do:
      sequence:
        - turn: {angle: 360}
          timeout: 60
""",
    "Scenario": """\
scenario: a box appears
mission: explore
faults:
  - 'at 5.0: spawn_box ahead 1.0'
expect: {outcome: success}
""",
    "Requirements": """\
requirements:
  touches nothing: never collisions > 0
""",
    "Fleet": """\
fleet: untitled
world: empty_arena
robots:
  left:
    mission: explore
    start: {x: -1, y: 0, yaw: 180}
  right:
    mission: explore
    start: {x: 1, y: 0, yaw: 0}
""",
    "World": """\
# Metres and degrees; x to the right, y up, origin in the middle.
name: untitled
size: [6.4, 3.4]
spawn: {x: 0, y: 0, yaw: 0}
walls:
  - {name: north wall, from: [-3.1, 1.55], to: [3.1, 1.55], thickness: 0.1, height: 0.5}
  - {name: south wall, from: [-3.1, -1.55], to: [3.1, -1.55], thickness: 0.1, height: 0.5}
  - {name: east wall, from: [3.05, -1.6], to: [3.05, 1.6], thickness: 0.1, height: 0.5}
  - {name: west wall, from: [-3.05, -1.6], to: [-3.05, 1.6], thickness: 0.1, height: 0.5}
""",
}
"""By the name of what they are."""
