"""What must hold while a mission runs: formulas of signal temporal logic, and their signals."""
