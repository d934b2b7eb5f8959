"""What is known of a mission that runs elsewhere, and how it is shown: pure, fed by plain data."""
