"""The simulated world as pictures, and in a window."""
