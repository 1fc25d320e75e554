"""A plan in motion: start, steps, inputs inside a step, loops, snapshots."""
