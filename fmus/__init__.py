"""From a component to an FMU, and from an FMU to a verdict."""
