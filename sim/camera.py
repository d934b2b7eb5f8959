"""The camera: pictures drawn by MuJoCo's classic renderer on EGL, without a screen or a GPU.

The picture is drawn in this process: every way of lacking EGL that was tried (no library, no
driver, no device) raises an exception and leaves the process alive.
"""

from __future__ import annotations

import os
from functools import cache
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from bt_mission.common.errors import BtMissionError
from bt_mission.common.robot import Camera as CameraSpec
from sim.names import BASE, CAMERA, LOOKS, ROBOT, SCREENS

Image = npt.NDArray[np.uint8]


class NoCameraError(BtMissionError):
    """No picture can be drawn on this machine."""


class Camera:
    """Draws what the robot's camera sees: 8-bit RGB, `height` x `width` x 3, top row first.

    Raises NoCameraError where there is no EGL.
    """

    def __init__(self, model: mujoco.MjModel, spec: CameraSpec, prefix: str = "") -> None:
        self._model = model
        own = model.geom_bodyid == model.body(prefix + BASE).id
        self._own_screen = np.flatnonzero(own & (model.geom_group == SCREENS))
        try:
            self._gl = _gl_context()
            self._gl.make_current()
            self._context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100.value)
        # PyOpenGL and the bindings raise ImportError, AttributeError, RuntimeError, EGLError or
        # FatalError, by what is missing; none of them shall stop a run that could do without.
        except Exception as error:
            raise NoCameraError(
                "EGL cannot be used on this machine"
                f" ({type(error).__name__}: {_first_line(error)});"
                " install it with: apt-get install libegl1 libgl1-mesa-dri libopengl0"
            ) from error
        self._rect = mujoco.MjrRect(0, 0, spec.width, spec.height)
        self._scene = mujoco.MjvScene(model, maxgeom=model.ngeom + 100)
        for flag in (mujoco.mjtRndFlag.mjRND_SHADOW, mujoco.mjtRndFlag.mjRND_REFLECTION):
            self._scene.flags[flag] = False
        self._options = mujoco.MjvOption()
        self._options.geomgroup[[LOOKS, ROBOT]] = 0  # a camera does not see what carries it
        self._options.geomgroup[SCREENS] = 1
        self._view = mujoco.MjvCamera()
        self._view.type = mujoco.mjtCamera.mjCAMERA_FIXED
        self._view.fixedcamid = model.camera(prefix + CAMERA).id
        self._pixels = np.empty((spec.height, spec.width, 3), dtype=np.uint8)

    def draw(self, data: mujoco.MjData, out: Image) -> None:
        """Draw into `out`; positions in `data` must be current."""
        self._gl.make_current()
        self._model.geom_group[self._own_screen] = ROBOT
        mujoco.mjv_updateScene(
            self._model,
            data,
            self._options,
            None,
            self._view,
            mujoco.mjtCatBit.mjCAT_ALL.value,
            self._scene,
        )
        self._model.geom_group[self._own_screen] = SCREENS
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, self._context)
        mujoco.mjr_render(self._rect, self._scene, self._context)
        mujoco.mjr_readPixels(self._pixels, None, self._rect, self._context)
        out[:] = self._pixels[::-1]  # OpenGL's first row is the lowest

    def close(self) -> None:
        """Give the renderer back. Nothing can be drawn afterwards."""
        self._gl.make_current()
        self._context.free()


@cache
def _gl_context() -> Any:
    """Return the GL context of this process; all cameras draw in it, on one thread.

    It is kept: what Mesa compiles for a new one takes as long as eighty pictures.
    """
    # Mesa's software renderer hands even a small picture round to a thread for every core: on a
    # busy machine waiting for them costs more than the picture.
    os.environ.setdefault("LP_NUM_THREADS", "1")
    # Loads the system's libEGL: only when a picture is wanted.
    from mujoco.egl import GLContext  # noqa: PLC0415

    return GLContext(0, 0)  # the size is that of the buffer in the model


def _first_line(error: Exception) -> str:
    return (str(error).splitlines() or ["no reason given"])[0][:200]
