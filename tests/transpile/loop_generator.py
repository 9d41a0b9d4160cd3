"""Random programs whose loops, functions and conditions the evaluation may keep."""

from __future__ import annotations

import random

_HEAD = """import math
import random
from dataclasses import dataclass
from enum import Enum
from helper import *


class Kind(Enum):
    LOW = 1
    HIGH = 2

    @property
    def tall(self):
        return self.value * 0.7


@dataclass
class Part:
    x: float
    size: float
    kind: Kind
    name: str = "part"

    def area(self):
        return self.size * self.kind.value

    def moved(self, by):
        return Part(self.x + by, self.size, self.kind, self.name)


PARTS = [Part({parts})]
TABLE = {table}
COLORS = [(1, 0, 0), (0, 1, 0), (0.2, 0.4, 0.6)]
SIZES = {{"part": 0.5, "leg": 0.75, "arm": 1.25}}


def points(n):
    for i in range(n):
        yield i * 0.5, {point}


@register()
def piece(size: float = 1.0, count: int = 2, color=(0.5, 0.5, 0.5)) -> Shape:
    parts = []
    for k in range(count):
        parts.append(transform_shape(primitive_call("cube", color=color, shape_kwargs={{"scale": (size, {inner}, 1)}}), translation_matrix((k, 0, 0))))
    return concat_shapes(*parts)


@register()
def scene() -> Shape:
    parts = []
    other = []
    total = 0.0
    count = 1
    shift = PARTS[0].moved(0.25).x
"""


class LoopPrograms:
    """Writer of random programs; the same seed gives the same program."""

    def __init__(self, seed: int) -> None:
        self._random = random.Random(seed)

    def program(self) -> str:
        """Return a program."""
        pick = self._random
        parts = "), Part(".join(
            f"{pick.choice([0, 1, 2.5, -1])}, {pick.choice([0.5, 1, 2.0])}, Kind.{pick.choice(['LOW', 'HIGH'])}, "
            f"{pick.choice(['part', 'leg', 'arm'])!r}"
            for _ in range(pick.randint(1, 5))
        )
        rows = [(pick.randint(-3, 3), pick.choice([0.5, 1.0, 1.5, 2]), pick.choice(["a", "b"])) for _ in range(4)]
        head = _HEAD.format(
            parts=parts, table=rows, point=pick.choice(["i * i", "math.sin(i)", "1.5"]),
            inner=pick.choice(["0.2 * k + 0.1", "size", "1 / (k + 1)"]),
        )  # fmt: skip
        body: list[str] = []
        for _ in range(pick.randint(1, 4)):
            body += self._block(4, 0, ["shift"])
        body.append(
            "    " + pick.choice(["return concat_shapes(*parts, *other)", "return concat_shapes(*other, *parts)"])
        )
        return head + "\n".join(body) + "\n"

    def _number(self, names: list[str], depth: int = 0) -> str:
        pick = self._random
        if depth > 1 or pick.random() < 0.4:
            return pick.choice([*names, *names, "1", "0.5", "2", "total", "count"])
        left, right = self._number(names, depth + 1), self._number(names, depth + 1)
        return pick.choice(
            [f"({left} + {right})", f"({left} * {right})", f"({left} - {right})", f"math.cos({left})", f"abs({left})",
             f"({left} if {self._test(names)} else {right})", f"max({left}, {right})", f"{left} / 4"]
        )  # fmt: skip

    def _test(self, names: list[str]) -> str:
        pick = self._random
        name = pick.choice(names)
        return pick.choice(
            [f"{name} > {pick.choice([0, 0.5, 1, 2])}", f"{name} <= 1", f"0 <= {name} < 2", f"not {name} > 1",
             f"{name} > 0 and {name} < 3", f"count > 2 or {name} > 1", "True"]
        )  # fmt: skip

    def _shape(self, names: list[str]) -> str:
        pick = self._random
        if pick.random() < 0.04:
            return f"concat_shapes(primitive_call('cube'), *{pick.choice(['parts', 'other'])}[:20])"
        if pick.random() < 0.04:
            return "transform_shape(concat_shapes(primitive_call('cube'), *other), translation_matrix((0, 1, 0)))"
        if pick.random() < 0.3:
            call = pick.choice(
                [f"library_call('piece', size={self._number(names)})", "library_call('piece', count=3)",
                 f"library_call('piece', size={self._number(names)}, count={pick.choice([1, 2])})",
                 f"library_call('piece', color=(0.1, 0.2, min(1, abs({self._number(names)}))))"]
            )  # fmt: skip
        else:
            color = pick.choice(["(1, 0, 0)", "COLORS[count % 3]", "COLORS[0]"])
            call = f"primitive_call('sphere', color={color}, shape_kwargs={{'radius': 1 + abs({self._number(names)})}})"
        place = ", ".join(self._number(names) for _ in range(3))
        return f"transform_shape({call}, translation_matrix(({place})))"

    def _added(self, names: list[str]) -> str:
        name = self._random.choice(["parts", "parts", "other"])
        shape = self._shape(names)
        return self._random.choice([f"{name}.append({shape})", f"{name} += [{shape}]", f"{name}.extend([{shape}])"])

    def _block(self, indent: int, depth: int, names: list[str]) -> list[str]:
        pick = self._random
        space = " " * indent
        kind = pick.choice(["for", "for", "for", "for", "comprehension", "loop", "add", "if", "assign", "draw"])
        if depth > 2 and kind == "for":
            kind = "add"
        if kind == "comprehension":
            target, items, own = self._items()
            shape = self._shape([*names, *own])
            test = f" if {self._test([*names, *own])}" if pick.random() < 0.3 else ""
            return [f"{space}parts += [{shape} for {target} in {items}{test}]"]
        if kind == "loop":
            return [f"{space}parts.append(loop({pick.randint(0, 4)}, lambda i: {self._shape([*names, 'i'])}))"]
        if kind == "if":
            inner = [" " * (indent + 4) + self._added(names)]
            lines = [f"{space}if {self._test(names)}:", *inner]
            return lines + ([f"{space}else:", " " * (indent + 4) + self._added(names)] if pick.random() < 0.5 else [])
        if kind == "assign":
            return [
                space + pick.choice(["total += 0.5", "count += 1", f"total = {self._number(names)}", "total -= shift"])
            ]
        if kind == "draw":
            return [f"{space}parts.append({self._shape([*names, 'random.uniform(0, 1)'])})"]
        if kind == "add":
            return [space + self._added(names)]
        target, items, own = self._items()
        known = [*names, *own]
        lines = [f"{space}for {target} in {items}:"]
        if pick.random() < 0.3:
            lines.append(f"{space}    here = {self._number(known)}")
            known.append("here")
        if pick.random() < 0.1:
            lines.append(f"{space}    if {self._test(known)}: continue")
        for _ in range(pick.randint(1, 3)):
            lines += self._block(indent + 4, depth + 1, known)
        if pick.random() < 0.25:
            lines.append(
                space + "    " + pick.choice(["total += 0.25", "count += 1", f"total += {self._number(known)}"])
            )
        return lines

    def _items(self) -> tuple[str, str, list[str]]:
        pick = self._random
        name = pick.choice(["i", "j", "k"])
        return pick.choice(
            [(name, f"range({pick.randint(0, 5)})", [name]), (name, f"range(1, {pick.randint(2, 6)}, 2)", [name]),
             ("p", "PARTS", ["p.x", "p.size", "p.area()", "p.kind.tall", "SIZES[p.name]", "p.moved(1).x"]),
             (f"{name}, p", "enumerate(PARTS)", [name, "p.size", "p.kind.value", "len(p.name)"]),
             ("a, b, c", "TABLE", ["a", "b", "(1 if c == 'a' else 2)"]), ("a, b", "points(4)", ["a", "b"]),
             ("a, b", "zip(range(3), [0.5, 1, 2.5])", ["a", "b"]), ("s, v", "SIZES.items()", ["v", "len(s)"]),
             ("v", "sorted(SIZES.values())", ["v"]), ("e", "Kind", ["e.value", "e.tall", "(1 if e is Kind.LOW else 2)"]),
             ("v", "(n * 0.5 + total for n in range(3))", ["v"]), ("v", "map(lambda n: n + count, range(2))", ["v"]),
             ("e, f", "[(a, b) for a in Kind for b in reversed(Kind)]", ["e.value", "(0.5 if e == f else 1.5)"])]
        )  # fmt: skip
