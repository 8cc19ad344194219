"""Pictures, and views in the terminal."""
