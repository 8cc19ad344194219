"""The words of a TurtleBot."""
