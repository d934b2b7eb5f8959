"""The entry point of benchmarks and campaigns: lists, runs and compares them."""
