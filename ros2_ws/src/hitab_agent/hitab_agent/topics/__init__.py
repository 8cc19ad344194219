"""Topics of an agent, and the distribution of behaviors."""
