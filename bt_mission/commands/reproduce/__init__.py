"""From the recording of a robot to a scenario that repeats it in the simulation.

`joined` makes one file of several, `evidence` reads it, `world`, `mission` and
`symptoms` derive a world, a mission and faults, `case` writes them, `comparison` states how near a
run of them comes, and `session` puts all of it together and searches the guessed parameters.
"""
