"""Strongly connected components of directed graphs (Tarjan, without recursion)."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping
from typing import TypeVar

Vertex = TypeVar("Vertex", bound=Hashable)


def strong_components(edges: Mapping[Vertex, Iterable[Vertex]]) -> list[list[Vertex]]:
    """The components, each after all that it leads to."""
    found: list[list[Vertex]] = []
    number: dict[Vertex, int] = {}
    low: dict[Vertex, int] = {}
    stack: list[Vertex] = []
    on_stack: set[Vertex] = set()
    for root in list(edges):
        if root in number:
            continue
        work = [(root, iter(edges.get(root, ())))]
        number[root] = low[root] = len(number)
        stack.append(root)
        on_stack.add(root)
        while work:
            vertex, followers = work[-1]
            follower = next(followers, None)
            if follower is None:
                work.pop()
                if work:
                    low[work[-1][0]] = min(low[work[-1][0]], low[vertex])
                if low[vertex] == number[vertex]:
                    part = [stack.pop()]
                    while part[-1] != vertex:
                        part.append(stack.pop())
                    on_stack.difference_update(part)
                    found.append(part[::-1])
            elif follower not in number:
                number[follower] = low[follower] = len(number)
                stack.append(follower)
                on_stack.add(follower)
                work.append((follower, iter(edges.get(follower, ()))))
            elif follower in on_stack:
                low[vertex] = min(low[vertex], number[follower])
    return found


def has_cycle(edges: Mapping[Vertex, Iterable[Vertex]]) -> bool:
    """Whether some vertex leads back to itself."""
    return any(
        len(part) > 1 or part[0] in set(edges.get(part[0], ())) for part in strong_components(edges)
    )
