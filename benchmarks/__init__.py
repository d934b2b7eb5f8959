"""What the software costs, measured: `python -m benchmarks` lists the benchmarks and runs them."""
