"""How well policies fly missions."""
