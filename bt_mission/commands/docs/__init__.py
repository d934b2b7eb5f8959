"""``bt-mission docs``: the documentation in the terminal."""
