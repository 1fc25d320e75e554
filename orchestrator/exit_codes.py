"""Exit codes of every command."""

DONE = 0
FAILED = 1  # the run or the check failed
MISUSED = 2  # bad usage or config
STOPPED = 130  # interrupted
