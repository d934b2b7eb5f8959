"""One simulated robot: body, sensors and drive."""
