"""Six closed loops on simulated objects, over the public API: a benchmark and an example."""
