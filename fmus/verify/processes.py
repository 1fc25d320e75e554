"""Processes that end with the one that started them, and take with them what they started."""

from __future__ import annotations

import contextlib
import ctypes
import os
import sys
import time
from pathlib import Path

PR_SET_PDEATHSIG, PR_SET_CHILD_SUBREAPER = 1, 36  # linux/prctl.h
SIGKILL = 9  # on every Unix; the name is missing elsewhere
PATIENCE = 2.0  # s until processes that were killed are gone


def die_with_parent() -> None:
    """On Linux, be killed when the parent ends, however it does."""
    _prctl(PR_SET_PDEATHSIG, SIGKILL)


def adopt_orphans() -> None:
    """On Linux, become the parent of descendants whose own parent has ended."""
    _prctl(PR_SET_CHILD_SUBREAPER, 1)


def _prctl(option: int, value: int) -> None:
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(option, ctypes.c_ulong(value), 0, 0, 0)


def end_group(leader: int) -> None:
    """Kill the process group of a child, which may have ended itself."""
    for kill in (os.killpg, os.kill):  # the group is not there before the child has made it
        with contextlib.suppress(ProcessLookupError, PermissionError):
            kill(leader, SIGKILL)


def end_orphans() -> None:
    """Kill and wait for whatever descendants are left."""
    deadline = time.monotonic() + PATIENCE
    while time.monotonic() < deadline:
        for pid in _children():
            end_group(pid)
        try:
            while os.waitpid(-1, os.WNOHANG)[0]:
                pass
        except ChildProcessError:
            return
        time.sleep(0.001)


def _children() -> list[int]:
    try:
        return [int(p) for p in Path("/proc/thread-self/children").read_text().split()]
    except OSError:  # another platform
        return []
