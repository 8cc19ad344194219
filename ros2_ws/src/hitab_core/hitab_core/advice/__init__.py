"""What to ask and to propose to a demonstrator; see the modules."""
