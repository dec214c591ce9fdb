"""The benchmarks that `tools/bench.py` runs: cutjoint beside its peers."""
