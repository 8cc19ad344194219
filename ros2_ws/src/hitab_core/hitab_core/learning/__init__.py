"""Learning the transition function of a state from its examples."""
