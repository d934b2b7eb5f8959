"""The MuJoCo model: bodies, contacts, wheels, props."""
