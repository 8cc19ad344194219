"""What all nodes share: names, qualities of service, conversions, executor loop."""
