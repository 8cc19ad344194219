"""Exit codes that a node's process reports to its supervisor."""

DO_NOT_RESTART = 3
"""Exit code of a process that should not be restarted."""

FINAL_AFTER = "HITAB_FINAL_AFTER_S"
"""Environment variable with the start period, s, in which a supervisor restarts a process whatever
its exit code. A process that should not be restarted waits for the end of this period."""
