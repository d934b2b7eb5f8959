"""Facts about one picture a second."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
from PIL import Image as Picture

from action_servers.camera.take_pictures import TakePictures, compressed
from action_servers.core.maneuver import ZERO, ErrorCode, Finished, Image, Observation


class Camera:
    """Sends a picture each tenth of a second while it is on."""

    def __init__(self):
        self.is_on = self.is_broken = False
        self.image: Image | None = None

    def on(self):
        self.is_on = True

    def off(self):
        self.is_on = False

    def observe(self, time_s):
        if self.is_on and not self.is_broken and round(time_s * 20) % 2 == 0:
            self.image = Image(time_s, 24, 32, np.full((24, 32, 3), 200, dtype=np.uint8), "eye")
        return Observation(time_s, image=self.image)


def run(maneuver, camera, seconds):
    """What was told when, how long the camera was on, and the end."""
    reports: list[Any] = []
    steps_on = 0
    for step in range(round(seconds * 20) + 1):
        time_s = 10.0 + step / 20
        answer = maneuver.step(camera.observe(time_s))
        steps_on += camera.is_on
        feedback = maneuver.feedback()
        if feedback is not None:
            reports.append((round(time_s - 10.0, 6), feedback["last_image"]))
        if isinstance(answer, Finished):
            return reports, steps_on, answer
        assert answer == ZERO
    return reports, steps_on, None


def test_one_a_second_beginning_at_the_first_second():
    """Each with feedback; the result has all of them; the camera is on only for a moment each."""
    camera = Camera()
    taking = TakePictures(3, camera)
    reports, steps_on, end = run(taking, camera, 5.0)
    assert end == Finished("succeeded")
    assert [time for time, _ in reports] == [1.1, 2.1, 3.1]
    assert taking.result() == {"all_pictures": tuple(image for _, image in reports)}
    assert steps_on == 6


def test_a_picture_is_a_jpeg_with_stamp_and_frame():
    """As in a sensor_msgs/CompressedImage."""
    rgb = np.zeros((24, 32, 3), dtype=np.uint8)
    rgb[:, :, 2] = 250
    fields: Any = compressed(Image(12.5, 24, 32, rgb, "eye"), 90)
    assert fields["header"] == {"stamp": 12.5, "frame_id": "eye"}
    assert fields["format"] == "jpeg"
    with Picture.open(io.BytesIO(fields["data"])) as picture:
        assert (picture.format, picture.size) == ("JPEG", (32, 24))
        assert np.asarray(picture)[12, 16].tolist()[2] > 240


def test_a_camera_that_stops_ends_it_with_what_was_taken():
    """Two seconds after the picture was due."""
    camera = Camera()
    taking = TakePictures(3, camera)
    run(taking, camera, 1.5)
    camera.is_broken = True
    _, _, end = run(taking, camera, 5.0)
    assert end == Finished(
        "aborted", ErrorCode.NO_IMAGE, "no image from the camera within 2 s, 1 of 3 taken"
    )
    pictures: Any = taking.result()["all_pictures"]
    assert len(pictures) == 1
