"""Plants: what moves, and how."""
