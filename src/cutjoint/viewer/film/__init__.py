"""A motion as a page that plays it: the recording, its animation, and the page as one file."""
