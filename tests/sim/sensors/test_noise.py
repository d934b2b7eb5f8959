"""Noise depends on seed, sensor and measurement, and on nothing else."""

import numpy as np
import pytest

from sim.sensors.noise import Noise


def test_the_same_seed_sensor_and_index_give_the_same_values():
    """Two sources made alike agree."""
    assert np.array_equal(Noise(1, "lidar", 5).at(7), Noise(1, "lidar", 5).at(7))


@pytest.mark.parametrize("index", [0, 63, 64, 1000])
def test_what_was_measured_before_does_not_matter(index):
    """A measurement's noise is the same whether or not earlier ones were taken."""
    source = Noise(3, "imu", 6)
    for earlier in (0, 5, 70, 2):
        source.at(earlier)
    assert np.array_equal(source.at(index), Noise(3, "imu", 6).at(index))


def test_seed_sensor_and_index_each_change_it():
    """None of the four share a value."""
    values = [
        Noise(1, "lidar", 4).at(0),
        Noise(2, "lidar", 4).at(0),
        Noise(1, "imu", 4).at(0),
        Noise(1, "lidar", 4).at(1),
    ]
    assert len({tuple(row) for row in values}) == 4


def test_it_is_normal_with_standard_deviation_one():
    """Mean 0 and deviation 1 over 100,000 values."""
    source = Noise(0, "lidar", 1000)
    values = np.concatenate([source.at(index) for index in range(100)])
    assert values.mean() == pytest.approx(0, abs=0.01)
    assert values.std() == pytest.approx(1, abs=0.01)


def test_any_whole_number_is_a_seed():
    """Negative and huge seeds work."""
    assert Noise(-1, "lidar", 3).at(0).shape == (3,)
    assert Noise(2**80, "lidar", 3).at(0).shape == (3,)
