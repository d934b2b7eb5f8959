"""A door for agents: they propose missions, collect evidence, and drive with a person's permit."""
