"""The system as a graph: instances, connections, and the checks of both."""
