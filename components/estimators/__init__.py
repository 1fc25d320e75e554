"""Estimators: what measurements say about what is not measured."""
