"""The back end that compiles in memory with LLVM."""
