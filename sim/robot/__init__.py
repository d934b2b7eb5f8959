"""One simulated robot: body, sensors and drive put together."""
