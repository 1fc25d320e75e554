"""The native target: C generated from the block's equations, and the C runtime around it."""
