"""A gateway for agents, which propose missions, collect evidence, and drive with a permit."""
