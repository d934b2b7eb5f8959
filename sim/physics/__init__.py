"""The MuJoCo model: bodies, contacts, wheels, obstacles that come and go."""
