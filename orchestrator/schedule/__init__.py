"""From the graph to a plan: order, rates, loops, and where every value lives."""
