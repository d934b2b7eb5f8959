"""The results of a sweep on the terminal, and as one page of HTML that needs no network.

- ``factors``: how success depends on what was varied
- ``explanation``: the factor that explains a cause of failures
- ``charts``: figures as data for Plotly
- ``terminal``: the tables of the terminal
- ``page``: the page, by the template ``sweep.html``
"""
