"""Where to cut a robot that is there already: frames that a loop closes at, types of cuts, other spanning trees."""
