"""The papers' experiments: set-ups, runs, claims with a verdict."""
