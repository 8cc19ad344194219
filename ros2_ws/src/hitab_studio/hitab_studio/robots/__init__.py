"""Real robots on the page: where they are, what their sensors say, their cameras and their map."""
