"""Pictures and views of the terminal."""
