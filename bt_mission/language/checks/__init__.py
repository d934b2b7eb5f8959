"""What is checked in a mission before anything moves."""
