"""Entities as a short tree: a few lines, level by level, neighbours that look alike counted together."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import islice
from typing import Any

from scenelang.interpreter.entity import Entity, Frames, Scene
from scenelang.interpreter.show import show
from scenelang.interpreter.values import Matrix, MutableList, Pair, Vector

_LOOKED_AT = 20_000  # parts of one entity that are looked at
_MOST_FACTS = 60


@dataclass(slots=True)
class _Node:
    label: str
    parts: Sequence[Any]
    children: list[_Node] = field(default_factory=list)
    hidden: str = ""


def tree_lines(value: Entity | Scene | Frames, most: int) -> list[str]:
    """The tree of an entity, or of the first frame of a scene; at most ``most`` lines."""
    if isinstance(value, Frames):
        return [f"{len(value.frames):,} frames; the first:", *_drawn(_Node("parts", value.frames[0]), most - 1)]
    if isinstance(value, Scene):
        root = value.root
        if value.animated:
            return [f"{len(value.frames):,} frames; the first:", *_drawn(_node(root, 1), most - 1)]
        return _drawn(_node(root, 1), most)
    return _drawn(_node(value, 1), most)


def parts_tree(value: Pair | MutableList, most: int) -> list[str]:
    """The tree of parts, a list of entities and pairs ``(Entity . Matrix)``; empty when the value is none."""
    items = list(islice(_items(value), _LOOKED_AT + 1))
    if type(value) is Pair and type(value.car) is Entity and type(value.cdr) is Matrix:
        items = [value]
    if not items or not all(_is_part(item) for item in items):
        return []
    count = f"{len(items):,}" if len(items) <= _LOOKED_AT else f"more than {_LOOKED_AT:,}"
    return _drawn(_Node(f"{count} part{'' if len(items) == 1 else 's'}", [_as_part(item) for item in items]), most)


def _items(value: Any) -> Iterator[Any]:
    if type(value) is MutableList:
        yield from value.items
        return
    while type(value) is Pair:
        yield value.car
        value = value.cdr


def _is_part(item: Any) -> bool:
    return type(item) is Entity or (type(item) is Pair and type(item.car) is Entity and type(item.cdr) is Matrix)


def _as_part(item: Any) -> Any:
    return item if type(item) is Pair else Pair(item, None)


def _node(entity: Entity, count: int) -> _Node:
    times = f"{count:,} x " if count > 1 else ""
    return _Node(f"{times}{entity.word}{_facts(entity) if count == 1 else ''}", entity.children)


def _facts(entity: Entity) -> str:
    """Handle, text and attributes, in brief."""
    z = entity.embedding
    facts = [f"<{z.handle}>"] if z.handle else []
    facts += [f'"{z.text[:40]}"'] if z.text else []
    facts += [f":{name} {_brief(value)}" for name, value in islice(z.attributes.items(), 6)]
    text = " ".join(facts)
    return f"  {text[:_MOST_FACTS]}{'...' if len(text) > _MOST_FACTS else ''}" if text else ""


def _brief(value: Any) -> str:
    if type(value) is float:
        return f"{value:.4g}"
    if type(value) is Vector:
        return "[" + " ".join(f"{x:.4g}" for x in value[:4]) + ("..." if len(value) > 4 else "") + "]"
    return show(value, 40)


def _drawn(root: _Node, most: int) -> list[str]:
    """Level by level as far as the lines go, then drawn from the top."""
    left = most - 1
    waiting = deque([root])
    while waiting:
        node = waiting.popleft()
        groups = _groups(node.parts)
        if not groups:
            continue
        rest = len(node.parts) - min(len(node.parts), _LOOKED_AT)
        if left <= 0:
            node.label += f"  ... {_parts(len(node.parts))}"
            continue
        fits = len(groups) if len(groups) <= left and not rest else max(0, left - 1)
        node.children = [_node(entity, count) for entity, count in groups[:fits]]
        hidden = sum(count for _, count in groups[fits:]) + rest
        if hidden:
            node.hidden = f"... {hidden:,} more" if fits else f"... {_parts(hidden)}"
        left -= fits + (1 if hidden else 0)
        waiting.extend(node.children)
    return list(_rows(root, "", ""))


def _parts(count: int) -> str:
    return f"{count:,} part{'' if count == 1 else 's'}"


def _rows(root: _Node, prefix: str, inner: str) -> Iterator[str]:
    stack = [(root, prefix, inner)]
    while stack:
        node, prefix, inner = stack.pop()
        yield prefix + node.label
        below: list[_Node] = [*node.children, *([_Node(node.hidden, ())] if node.hidden else [])]
        for number, child in reversed(list(enumerate(below))):
            last = number == len(below) - 1
            stack.append((child, inner + ("└─ " if last else "├─ "), inner + ("   " if last else "│  ")))


def _groups(parts: Iterable[Any]) -> list[tuple[Entity, int]]:
    """Neighbours with one word and the same number of parts, counted."""
    found: list[tuple[Entity, int]] = []
    for part in islice(parts, _LOOKED_AT):
        entity = part.car
        if found and found[-1][0].word == entity.word and len(found[-1][0].children) == len(entity.children):
            found[-1] = (found[-1][0], found[-1][1] + 1)
        else:
            found.append((entity, 1))
    return found
