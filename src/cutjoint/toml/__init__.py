"""Files of TOML, key by key: all that is wrong is told at once, with lines and the nearest known key."""
