"""Texts that differ in numbers only: thousands of them are told once, with how many there are."""

from __future__ import annotations

import re
from collections.abc import Iterable

NUMBER = re.compile(r"\d+")
FEW = 8  # more texts than this that differ in numbers only are told once


def without_numbers(text: str) -> str:
    """What texts that are alike have in common."""
    return NUMBER.sub("#", " ".join(text.split()))


def few(texts: Iterable[str]) -> list[str]:
    """The texts in their order; of many alike the first, how many, and the last."""
    groups: dict[str, list[str]] = {}
    words = [(without_numbers(text), text) for text in texts]
    for key, text in words:
        groups.setdefault(key, []).append(text)
    found = []
    for key, text in words:
        group = groups[key]
        if len(group) <= FEW:
            found.append(text)
        elif text is group[0]:
            found += [text, f"... {len(group) - 2} alike ...", group[-1]]
    return found
