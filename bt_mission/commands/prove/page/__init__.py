"""A proof as a page: its properties, the tree with its outcomes, and the findings."""
