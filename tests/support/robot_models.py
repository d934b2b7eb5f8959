"""Robots of several kinds with a MuJoCo model, as models of the field are written."""

from __future__ import annotations

import math
import re
from pathlib import Path

from bt_mission.base.files import find
from bt_mission.robots.model import load_robot

MODELLED = ("husky", "rosbot", "f1tenth")
"""Skid-steer, omnidirectional, Ackermann."""
TETRAHEDRON = "v 0 0 0\nv .02 0 0\nv 0 .02 0\nv 0 0 .02\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"


def write_model(folder: Path, name: str, *changes: tuple[str, str]) -> Path:
    """Write a shipped robot with a model: its figures as MJCF, as models of the field have them."""
    robot = load_robot(name)
    x, y, z = robot.base_centre_of_mass
    a, b, c = robot.base_inertia
    height, width = robot.drive.wheel_radius - robot.base_height, robot.drive.wheel_width / 2
    lx, ly, lz = robot.body.size
    cx, cy, cz = robot.body.centre
    wheels = "".join(
        f"""<body name="hub_{wheel}" pos="{px} {py} {height}" euler="0 0 {math.degrees(heading)}">
        {'<joint name="steer_' + wheel + '"/>' if name == "f1tenth" and "front" in wheel else ""}
        <inertial pos="0 0 0" mass="1e-4" diaginertia="1e-6 1e-6 1e-6"/>
        <body><joint name="{wheel}" axis="0 1 0"/>
          <geom class="tyre" size="{robot.drive.wheel_radius} {width}" euler="90 0 0"/>
          <body><joint axis="1 0 0"/><geom type="sphere" size="0.01" mass="1e-6"/></body>
        </body></body>"""
        for wheel, (px, py), heading in zip(
            robot.drive.names, robot.drive.places, robot.drive.headings, strict=True
        )
    )
    model = f"""<mujoco><compiler meshdir="assets"/>
    <default><default class="tyre"><geom type="cylinder" mass="1e-6"/></default></default>
    <include file="parts/meshes.xml"/>
    <worldbody><geom type="plane" size="9 9 1"/><body name="chassis"><freejoint/>
      <inertial pos="{x} {y} {z}" mass="{robot.base_mass}" diaginertia="{a} {b} {c}"/>
      <body name="cover" pos="{cx} {cy} {cz}">
        <geom type="box" mass="1e-6" size="{lx / 2} {ly / 2} {lz / 2}"/>
        <geom type="mesh" mesh="part" mass="0" contype="0" conaffinity="0"/></body>
      {wheels}</body></worldbody>
    <equality><joint joint1="{robot.drive.names[0]}" joint2="{robot.drive.names[1]}"/></equality>
    <actuator><motor joint="{robot.drive.names[0]}"/></actuator></mujoco>"""
    (folder / "assets").mkdir(exist_ok=True)
    (folder / "parts").mkdir(exist_ok=True)
    (folder / "assets" / "part.obj").write_text(TETRAHEDRON, encoding="utf-8")
    meshes = '<mujoco><asset><mesh name="part" file="part.obj"/></asset></mujoco>'
    (folder / "parts" / "meshes.xml").write_text(meshes, encoding="utf-8")
    figures = find("robots", name).read_text(encoding="utf-8")
    figures = re.sub(r"^base_(inertia|centre_of_mass):.*\n", "", figures, flags=re.MULTILINE)
    figures += (
        f"model:\n  file: {name}.xml\n  base: chassis\n  wheels: [{', '.join(robot.drive.names)}]\n"
    )
    if name == "f1tenth":
        figures += "  steering: [steer_front_left_wheel, steer_front_right_wheel]\n"
    for old, new in changes:
        assert old in figures + model
        figures, model = figures.replace(old, new, 1), model.replace(old, new, 1)
    (folder / f"{name}.xml").write_text(model, encoding="utf-8")
    path = folder / f"{name}.yaml"
    path.write_text(figures, encoding="utf-8")
    return path
