"""Many runs of one closed loop: traced, compiled into one loop, run in blocks, and gathered or streamed."""
