"""A run as a video: the world from above, the robot's camera, and the state of the mission.

The images come from the simulation (`sim.views.views`), through `recorder.Views`; here they become
frames, and a file.
"""
