"""The keys of a loops.toml: read and written, in a file of their own or inside another format."""
