"""The results of a sweep as one page of HTML that needs no network.

- ``columns``: what is needed of every row, as arrays
- ``factors``: how success depends on what was varied
- ``charts``: figures as data for Plotly
- ``sections``: the parts of the page that are text and tables
- ``coverage``: what of the tree all runs together have reached
- ``page``: the page, put together
"""
