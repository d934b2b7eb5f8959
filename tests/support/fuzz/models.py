"""MuJoCo models of robots, mutated as elements, attributes, numbers and characters.

A case is the name of a robot in a line, then the text of its model. It is checked, and a valid
model drives in a world.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from copy import deepcopy
from pathlib import Path
from random import Random
from xml.etree import ElementTree as ET

import mujoco

from bt_mission.base.diagnostics import InputError
from bt_mission.base.files import find
from bt_mission.robots.model import load_robot
from bt_mission.sessions.file_checks import check_robot
from sim.physics.names import STEP_NS
from sim.physics.spawn import RobotSpawn
from sim.simulation import Simulation
from sim.world.loader import load_world
from tests.support.fuzz.finding import Case, Verdict
from tests.support.fuzz.targets import Target
from tests.support.robot_models import MODELLED, write_model

_NUMBERS = ("0", "-1", "1e-12", "1e9", "1e11", "-0", "1e999", "nan", "0x10", "1,5", "9" * 400)
_WORDS = (
    *("", "true", "none", "mesh", "ball", "free", "plane", "box", "capsule", "hfield", "sdf", "é"),
)
_TAGS = (
    *("body", "geom", "joint", "freejoint", "site", "camera", "light", "inertial", "frame"),
    *("default", "mesh", "texture", "material", "position", "velocity", "motor", "general"),
    *("muscle", "cylinder", "adhesion", "damper", "equality", "connect", "weld", "tendon"),
    *("fixed", "spatial", "contact", "pair", "exclude", "sensor", "keyframe", "key", "custom"),
    *("include", "replicate", "composite", "attach", "plugin", "size", "option", "flag", "visual"),
)
_KEYS = (
    *("name", "class", "childclass", "type", "pos", "quat", "euler", "axisangle", "xyaxes"),
    *(
        "zaxis",
        "size",
        "fromto",
        "mass",
        "density",
        "range",
        "ref",
        "springref",
        "damping",
        "stiffness",
    ),
    *("armature", "frictionloss", "margin", "gap", "solref", "solimp", "condim", "contype"),
    *("gear", "kp", "kv", "dampratio", "ctrlrange", "forcerange", "actrange", "dyntype", "gainprm"),
    *("joint", "joint1", "joint2", "body1", "body2", "site", "mesh", "material", "file", "scale"),
    *("fitscale", "gravcomp", "mocap", "group", "fovy", "resolution", "angle", "eulerseq"),
    *("inertiafromgeom", "fusestatic", "discardvisual", "boundmass", "settotalmass", "strippath"),
)
_TEXTS = ("<", ">", '"', "&", "<!--", "]]>", "\x00", "\ufeff", "<!DOCTYPE x>", "<a>" * 300)


def corpus() -> tuple[tuple[str, str], ...]:
    """Return robots with their models."""
    return tuple((path.stem, path.with_suffix(".xml").read_text()) for path in _write(Path()))


def _write(folder: Path) -> list[Path]:
    arm = find("robots", "waffle_arm")
    own = folder / "waffle_arm.yaml"
    own.write_text(arm.read_text(encoding="utf-8"), encoding="utf-8")
    own.with_suffix(".xml").write_text(arm.with_suffix(".xml").read_text(encoding="utf-8"))
    return [own, *(write_model(folder, name) for name in MODELLED)]


def samples(known: tuple[tuple[str, str], ...]) -> Iterator[Case]:
    """Yield what is valid."""
    for name, text in known:
        yield Case("m.model", f"{name}\n{text}".encode())


def case(known: tuple[tuple[str, str], ...], seed: int, number: int) -> Case:
    """Return a changed model."""
    rng = Random(f"{seed}/{number}")
    name, text = rng.choice(known)
    if rng.random() < 0.1:
        at = rng.randrange(len(text))
        text = text[:at] + rng.choice(_TEXTS) + text[at + rng.choice((0, 0, 1, 20)) :]
        return Case("m.model", f"{name}\n{text}".encode("utf-8", "surrogatepass"))
    root = ET.fromstring(text)  # noqa: S314 - our own
    for _ in range(rng.choice((1, 1, 1, 2, 3, 6))):
        _change(rng, root)
    return Case("m.model", f"{name}\n{ET.tostring(root, encoding='unicode')}".encode())


def _change(rng: Random, root: ET.Element) -> None:
    elements = list(root.iter())
    element, other = rng.choice(elements), rng.choice(elements)
    match rng.randrange(8):
        case 0:
            element.insert(rng.randrange(len(element) + 1), deepcopy(other))
        case 1 if len(element):
            del element[rng.randrange(len(element))]
        case 2:
            element.tag = rng.choice(_TAGS)
        case 3:
            made = ET.SubElement(element, rng.choice(_TAGS))
            for key in rng.sample(_KEYS, rng.randrange(5)):
                made.set(key, _value(rng, other))
        case 4 if element.attrib:
            del element.attrib[rng.choice(list(element.attrib))]
        case 5:
            element.set(rng.choice(_KEYS), _value(rng, other))
        case _ if element.attrib:
            key = rng.choice(list(element.attrib))
            words = element.attrib[key].split() or [""]
            words[rng.randrange(len(words))] = _value(rng, other)
            element.set(key, " ".join(words))


def _value(rng: Random, other: ET.Element) -> str:
    chance = rng.random()
    if chance < 0.4:
        return rng.choice(_NUMBERS)
    if chance < 0.5:
        return " ".join(f"{rng.uniform(-2, 2):.3g}" for _ in range(rng.choice((1, 2, 3, 4, 6))))
    if chance < 0.8 and other.attrib:
        return rng.choice(list(other.attrib.values()))
    return rng.choice(_WORDS)


def judge(path: Path) -> Verdict:
    """Check a model beside the figures of its robot; a valid one drives for a second."""
    name, _, text = path.read_bytes().partition(b"\n")
    robot = Path(re.sub(r"\W", "", name.decode()) + ".yaml")
    robot.with_suffix(".xml").write_bytes(text)
    try:
        check_robot(robot)
    except InputError:
        return Verdict(accepted=False)
    simulation = Simulation(load_world("empty_arena"), [RobotSpawn(load_robot(robot))], seed=0)
    for _ in range(20):
        simulation.robots[0].command(0.2, 0.2)
        simulation.advance_to(simulation.time_ns + 10 * STEP_NS)
    assert isinstance(simulation.physics.model, mujoco.MjModel)
    return Verdict(accepted=True)


TARGET = Target(corpus, samples, case, judge)
