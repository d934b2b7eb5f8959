"""A run as one page of HTML that needs nothing else: no network, and for reading no JavaScript.

- ``page``: the page, put together
- ``figures``: what is reckoned from a run
- ``timeline``, ``plan``, ``charts``: the pictures, as SVG
- ``tables``: goals, leaves, the log, files
- ``data``: what the page's script is told
- ``markup``: HTML and numbers as text
"""
