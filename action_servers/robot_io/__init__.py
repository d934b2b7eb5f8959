"""The robot as its topics and parameters: commands out, sensors in."""
