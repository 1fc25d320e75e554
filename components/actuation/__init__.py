"""Actuation: from a wanted wrench to thrusters and back to a wrench."""
