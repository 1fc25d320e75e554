"""Monitors: error and energy functions of true states, to plot and to test."""
