"""The cost of the software, measured: `python -m benchmarks` lists the benchmarks and runs them."""
