"""Reads TOML as far as its standard promises: integers of 64 bits, and no endless nesting."""

from __future__ import annotations

import tomllib
from typing import Any

LEVELS = 32  # of tables and arrays in each other
INTEGERS = range(-(2**63), 2**63)


def parse(text: str) -> dict[str, Any]:
    """The data of a TOML text. Raises ValueError that says why it is none."""
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        raise
    except RecursionError:
        raise ValueError(f"it is nested deeper than {LEVELS} levels") from None
    except ValueError:  # Python reads no integer of thousands of digits
        raise ValueError("an integer in it has more than 64 bits") from None
    _check(data)
    return data


def _check(data: dict[str, Any]) -> None:
    """Raises ValueError for what other readers of TOML need not understand."""
    level: list[tuple[str, Any]] = [("", data)]
    for _ in range(LEVELS):
        level = [
            (f"{path}.{key}" if path else str(key), value)
            for path, holder in level
            for key, value in (holder.items() if isinstance(holder, dict) else enumerate(holder))
            if isinstance(value, dict | list | int)
        ]
        for path, value in level:
            if isinstance(value, int) and value not in INTEGERS:
                raise ValueError(f"{path} is an integer of more than 64 bits")
        level = [item for item in level if not isinstance(item[1], int)]
    if level:
        raise ValueError(f"it is nested deeper than {LEVELS} levels")
