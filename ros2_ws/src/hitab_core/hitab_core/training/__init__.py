"""Training: a session, its examples, and the journal that survives the process."""
