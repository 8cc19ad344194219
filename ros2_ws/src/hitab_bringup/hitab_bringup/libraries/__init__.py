"""The libraries of a swarm's agents: chosen, opened, and prepared for a run."""
