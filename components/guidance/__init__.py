"""Guidance: desired trajectories with their rates."""
