"""The Python target: pythonfmu FMUs that run the block's own numpy source."""
