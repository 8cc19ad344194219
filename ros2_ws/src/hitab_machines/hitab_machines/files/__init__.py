"""Files of a machine: what others may read, and the copies of theirs."""
