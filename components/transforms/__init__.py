"""Transforms: the same quantities in other frames and coordinates."""
