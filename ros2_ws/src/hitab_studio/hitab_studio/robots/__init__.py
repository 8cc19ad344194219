"""Real robots on the page: poses, sensors, cameras and the map."""
