"""Box foraging: a world in which swarms bring home boxes that no robot can move alone.

The task is that of Sullivan and Luke, *Hierarchical Training of Agent Behaviors* for swarms: boxes
lie on a field, and it takes five robots to pull a small one and twenty-five to pull a large one.
`domain` is what the robots can do and perceive, `world` the simulation.
"""
