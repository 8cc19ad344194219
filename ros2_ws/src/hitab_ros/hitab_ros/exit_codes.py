"""What the exit code of a node's process tells its supervisor."""

FINAL = 3
"""Exit code of a process that is not worth being started again."""

FINAL_AFTER = "HITAB_FINAL_AFTER_S"
"""Environment variable of a supervisor that tries again, whatever the exit code, what ends
earlier than so many seconds after its start: such a process ends no earlier."""
