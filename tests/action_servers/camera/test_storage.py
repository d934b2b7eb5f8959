"""Facts about where pictures go."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image as Picture

from action_servers.camera.camera_sweep import ImageFolder
from action_servers.core.maneuver import Image


@pytest.fixture
def image():
    """A picture of noise."""
    rgb = np.random.default_rng(7).integers(0, 255, (24, 32, 3), dtype=np.uint8)
    return Image(1.0, 24, 32, rgb)


def test_pictures_are_png_files_of_every_pixel(tmp_path, image):
    """Full paths, numbered with two digits."""
    store = ImageFolder(tmp_path / "images", "sweep")
    store.open()
    path = store.save(1, image)
    assert path == str(tmp_path / "images" / "sweep" / "image_01.png")
    with Picture.open(path) as picture:
        assert picture.format == "PNG"
        np.testing.assert_array_equal(np.asarray(picture), image.rgb)


def test_colours_that_lie_the_other_way_round_are_written_too(tmp_path, image):
    """A view with a negative stride, as a bgr8 picture gives."""
    store = ImageFolder(tmp_path)
    store.open()
    turned = Image(1.0, 24, 32, image.rgb[:, :, ::-1])
    with Picture.open(store.save(1, turned)) as picture:
        np.testing.assert_array_equal(np.asarray(picture), turned.rgb)


def test_every_goal_has_a_folder_of_its_own(tmp_path):
    """A name that is taken gets a number, and nothing in the older folder is touched."""
    folders = []
    for _ in range(3):
        store = ImageFolder(tmp_path, "sweep")
        store.open()
        folders.append(store.folder)
    assert folders == [str(tmp_path / name) for name in ("sweep", "sweep_2", "sweep_3")]


def test_the_path_is_full(tmp_path, monkeypatch):
    """Also when the folder was given relative to where the server runs."""
    monkeypatch.chdir(tmp_path)
    store = ImageFolder(tmp_path.__class__("images"))
    assert store.folder == ""
    store.open()
    assert store.folder == str(tmp_path / "images" / "images")


def test_a_file_in_the_way_is_told(tmp_path):
    """By the operating system's own error."""
    (tmp_path / "images").write_text("a file")
    with pytest.raises(OSError, match="File exists"):
        ImageFolder(tmp_path / "images").open()


def test_no_part_of_a_picture_is_left_when_the_disk_is_full(tmp_path, image, monkeypatch):
    """A torn file would be taken for a picture."""
    store = ImageFolder(tmp_path)
    store.open()

    def full(path, data):
        with path.open("wb") as file:
            file.write(bytes(data)[:10])
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(tmp_path.__class__, "write_bytes", full)
    with pytest.raises(OSError, match="No space left"):
        store.save(1, image)
    assert list((tmp_path / "images").iterdir()) == []


def test_a_folder_that_vanished_is_told(tmp_path, image):
    """Somebody tidied up during the sweep."""
    store = ImageFolder(tmp_path)
    store.open()
    (tmp_path / "images").rmdir()
    with pytest.raises(FileNotFoundError):
        store.save(1, image)
