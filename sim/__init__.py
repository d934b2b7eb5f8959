"""A TurtleBot3 in MuJoCo: worlds, robot and sensors (pure), and one ROS node over them."""

import importlib.util
import os
from pathlib import Path

# MuJoCo imports the renderer of this name, and fails if it cannot; this package chooses its own.
os.environ.pop("MUJOCO_GL", None)


def _name_window_library() -> None:
    """Name the library of windows of the package glfw.

    MuJoCo imports the package, which starts a Python process for each library that it finds, to ask
    for its version: a tenth of the time of a short mission.
    """
    chosen = os.environ.get("PYGLFW_LIBRARY") or os.environ.get("PYGLFW_LIBRARY_VARIANT")
    package = importlib.util.find_spec("glfw")
    if chosen or package is None or os.environ.get("XDG_SESSION_TYPE") == "wayland":
        return
    for folder in package.submodule_search_locations or ():
        library = Path(folder, "x11", "libglfw.so")
        if library.is_file():
            os.environ["PYGLFW_LIBRARY"] = str(library)


_name_window_library()
