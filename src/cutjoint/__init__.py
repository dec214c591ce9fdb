"""cutjoint: robots whose links form closed loops."""
