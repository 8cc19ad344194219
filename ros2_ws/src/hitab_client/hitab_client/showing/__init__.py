"""What is shown of a swarm: presence, groups and the world."""
