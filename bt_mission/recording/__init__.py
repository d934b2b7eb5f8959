"""Runs on disk, as MCAP files that ROS tools read.

- ``options``: what is recorded
- ``chunks``: MCAP as such, written fast
- ``file``: the file, written so that it can be read wherever it is cut
- ``definitions``: message definitions, gathered from the installed packages
- ``topics``: raw subscriptions to the topics of a graph
- ``goals``: requests to actions and their answers, as service events
- ``recorder``: one run on its way into a file
"""
