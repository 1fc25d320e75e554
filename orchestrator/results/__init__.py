"""What a run leaves: the results file, and figures of it."""
