"""Runs on disk, as MCAP files that ROS tools read.

- ``chunks``: MCAP as such, written fast
- ``file``: the file, written so that it can be read wherever it is cut
- ``topics``: the topics of a graph, taken as they are sent
- ``goals``: requests to actions and their answers, as service events
- ``contents``: what is recorded besides topics and goals
- ``writer``: one run on its way into a file
- ``reading``: a file, read wherever it is cut
- ``reader``: a file as what is known of its run (``model``)
- ``replay``: a file as the messages that a viewer would have received
"""
