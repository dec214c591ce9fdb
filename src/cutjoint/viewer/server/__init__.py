"""The viewer's server: addresses, the bridge to the tabs, and the files that it answers with."""
