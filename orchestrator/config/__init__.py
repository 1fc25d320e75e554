"""A config: TOML or code in, checked data out, and every problem with its place."""
