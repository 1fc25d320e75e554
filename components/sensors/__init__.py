"""Sensors: what a spacecraft measures."""
