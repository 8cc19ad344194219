"""The swarm as the studio knows it."""
