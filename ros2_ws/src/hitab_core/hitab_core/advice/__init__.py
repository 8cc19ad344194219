"""Questions and proposals to a demonstrator; see the modules."""
