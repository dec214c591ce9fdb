"""A headless browser as a camera: found, started, spoken to over pipes, and tidied up after."""
