"""A run as a film: the world from above, what the robot's camera sees, and what the mission does.

What is drawn comes from the simulation's side (`sim.views.views`), through `recorder.Views`; here
it becomes frames, and those a file.
"""
