"""The entry point of the benchmarks: what there is, how it is run, compared and written down."""
