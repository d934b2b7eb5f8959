"""A mission in a browser: a page with the content of the terminal views, over a WebSocket."""
