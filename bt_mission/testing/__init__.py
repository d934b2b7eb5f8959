"""What tests of missions are made of."""
