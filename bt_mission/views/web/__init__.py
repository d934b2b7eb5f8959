"""A mission in a browser: what a terminal shows, over a WebSocket, with a page of its own."""
