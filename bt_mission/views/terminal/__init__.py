"""The terminal views of a run: a live tree, plain lines, and the summary at the end."""
