"""Classes, operators and library functions that are translated, not evaluated: words and loops stay those of the Python."""

from __future__ import annotations

import contextlib
import io

import pytest

from scenelang.grammar.datum import Source
from scenelang.session.session import Session
from transpile.cases import first_difference, flattened, told
from transpile.reference_model import flatten

SESSION = Session()
HEAD = """from helper import *
import bisect, itertools, math, operator, statistics, string
import numpy as np
from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from functools import cached_property, partial, reduce
from typing import Generic, NamedTuple, ParamSpec, Protocol, TypeVar

def bar(x, y=0.0, size=1.0):
    return transform_shape(primitive_call('cube', shape_kwargs={'scale': size}), translation_matrix((x, y, 0)))

"""
VECTOR = """@dataclass
class Vec:
    x: float
    y: float
    def __add__(self, other):
        return Vec(self.x + other.x, self.y + other.y)
    def __sub__(self, other):
        return Vec(self.x - other.x, self.y - other.y)
    def __mul__(self, k):
        return Vec(self.x * k, self.y * k)
    def __rmul__(self, k):
        return self * k
    def __neg__(self):
        return Vec(-self.x, -self.y)
    def __abs__(self):
        return math.hypot(self.x, self.y)"""
POSE = """class Pose:
    def __init__(self, matrix=None):
        self.m = np.eye(4) if matrix is None else np.asarray(matrix, dtype=float)
    @classmethod
    def at(cls, x=0.0, y=0.0):
        return cls(translation_matrix((x, y, 0)))
    @classmethod
    def turn(cls, angle):
        return cls(rotation_matrix(angle, (0, 0, 1), (0, 0, 0)))
    def __matmul__(self, other):
        if isinstance(other, Pose):
            return Pose(self.m @ other.m)
        if isinstance(other, np.ndarray) and other.shape == (3,):
            return (self.m @ np.append(other, 1.0))[:3]
        return transform_shape(other, self.m)"""
PRODUCTS = """class Vec:
    def __init__(self, x, y):
        self.x, self.y = x, y
    def __add__(self, other):
        if not isinstance(other, Vec):
            return NotImplemented
        return Vec(self.x + other.x, self.y + other.y)
    def __mul__(self, other):
        if isinstance(other, Vec):
            return self.x * other.x + self.y * other.y
        elif isinstance(other, (int, float)):
            return Vec(self.x * other, self.y * other)
        else:
            raise TypeError(other)
    __rmul__ = __mul__"""
MEMBERS = """from enum import IntEnum, StrEnum
WIDTHS = {'empty': 3, 'full': 9}
class Fill(StrEnum):
    EMPTY = 'empty'
    FULL = 'full'
    @property
    def height(self):
        return {'empty': 1, 'full': 4}[self] + (self == 'full')
class Floor(IntEnum):
    LOW = 1
    HIGH = 3
    def above(self):
        return self * 2 + 1"""
ROW = """class Row:
    def __init__(self, items):
        self.items = items
    def __len__(self):
        return len(self.items)
    def __getitem__(self, i):
        return self.items[i]
    def __contains__(self, x):
        return x in self.items
    def __iter__(self):
        return iter(self.items)
    def __call__(self, x):
        return x * 2"""
PARTS = """class Part(ABC):
    scale = 2
    def __init__(self, x):
        self.x = x
    @abstractmethod
    def build(self): ...
    def moved(self, k=1.0):
        return bar(self.x * k, self.scale)
class Leg(Part):
    def build(self):
        return self.moved()
class Arm(Part):
    scale = 3
    def __init__(self, x, y):
        super().__init__(x)
        self.y = y
    def build(self):
        return concat_shapes(self.moved(k=2.0), bar(self.x, self.y))"""
DATA = """@dataclass(kw_only=True)
class Base:
    x: float = 1.0
@dataclass(kw_only=True)
class Derived(Base):
    y: float
    size: float = field(init=False)
    def __post_init__(self):
        self.size = self.x / 2
@dataclass
class Plain:
    x: float
    y: float = 2.0
@dataclass
class More(Plain):
    z: float = 3.0"""

LOWERED = {
    "operators": (VECTOR, "v = Vec(1, 2) + 2 * Vec(3, 4) - -Vec(0, 1) * 3\nparts.append(bar(v.x, v.y, abs(v)))"),
    "a container": (ROW, "r = Row([3, 5, 8])\nfor x in r:\n    parts.append(bar(x, len(r)))\n"
        "if 5 in r and 4 not in r:\n    parts.append(bar(r[1], r(7)))\nparts.append(bar(sum(r)))"),
    "a hierarchy": (PARTS, "for p in [Leg(1), Arm(2, 3), Leg(4)]:\n    parts.append(p.build())"),
    "a field of several classes": (PARTS, "for p in [Leg(1), Arm(2, 3)]:\n    parts.append(bar(p.x, p.scale))"),
    "a test for a base": (PARTS, "for p in [Leg(1), Arm(2, 3)]:\n    if isinstance(p, Part):\n        parts.append(bar(p.x))\n"
        "    if isinstance(p, Arm):\n        parts.append(bar(p.y, 5))"),
    "derived data": (DATA, "d = Derived(y=4.0)\nparts.append(bar(d.x, d.y, d.size))\nm = More(5.0)\nparts.append(bar(m.x, m.y, m.z))"),
    "what a data class does last": ("@dataclass\nclass Post:\n    x: float\n    y: float = 2.0\n    def __post_init__(self):\n"
        "        self.x = max(self.x, 3) + self.y", "parts.append(bar(Post(1).x))\nparts.append(bar(Post(5, y=1).x))"),
    "alternative constructors": ("class Hand:\n    def __init__(self, x):\n        self.x = x\n    @classmethod\n"
        "    def of(cls, x, k=2):\n        return cls(x * k)", "parts.append(bar(Hand.of(3).x))"),
    "cached properties": ("class Gear:\n    def __init__(self, n):\n        self.n = n\n    @cached_property\n    def radius(self):\n"
        "        return self.n / 4", "parts.append(bar(Gear(8).radius))"),
    "generic classes": ("S = TypeVar('S')\nclass Stack(Generic[S]):\n    def __init__(self):\n        self.items = []\n"
        "    def push(self, x):\n        self.items.append(x)\n        return self", "parts.append(bar(Stack().push(3).items[0]))"),
    "fixed arguments": ("ball = partial(primitive_call, 'sphere', color=(1, 0, 0))",
        "k = 3\nat = partial(bar, y=k / 2)\nparts += [ball(shape_kwargs={'radius': 2}), at(1), at(2, size=.5)]"),
    "pairs": ("", "for a, b in itertools.pairwise([1, 4, 9]):\n    parts.append(bar(a, b))"),
    "rows as arguments": ("", "parts.extend(itertools.starmap(bar, [(1, 2), (3, 4)]))"),
    "the beginning of an iterator": ("def g(n):\n    for i in range(n):\n        yield i * i",
        "for x in itertools.islice(g(9), 4):\n    parts.append(bar(x))"),
    "indices of an array": ("", "for i, j in np.ndindex(2, 3):\n    parts.append(bar(i, j))"),
    "keys of rows": ("", "for x, y in sorted([(1, 5), (2, 3)], key=operator.itemgetter(1)):\n    parts.append(bar(x, y))"),
    "a sum of shapes": ("", "parts.append(reduce(operator.add, [bar(1), bar(2)]))"),
    "bisection and means": ("", "i = bisect.bisect_left([1, 3, 5], 4)\nparts.append(bar(i, statistics.mean([1, 2, 6]), statistics.median([5, 1, 3, 2])))"),
    "letters": ("", "for i, c in enumerate(string.ascii_uppercase[:3]):\n    parts.append(bar(i, ord(c) - 64))"),
    "mixins whose methods ask the next class": ("class Base:\n    def __init__(self, x, y=0):\n        self.x, self.y = x, y\n"
        "    def parts(self):\n        return [bar(self.x, self.y)]\n"
        "class Twice:\n    def parts(self):\n        return super().parts() + [bar(self.x, self.y + .5)]\n"
        "class Shifted:\n    step = 2\n    def __init__(self, *args, by=1, **rest):\n        super().__init__(*args, **rest)\n        self.by = by\n"
        "    def parts(self):\n        return super().parts() + [bar(self.x + self.by * self.step)]\n"
        "class A(Twice, Base):\n    pass\nclass B(Shifted, Twice, Base):\n    step = 3\n    def parts(self):\n        return super().parts()[::-1]",
        "parts += A(1).parts() + B(4, by=2).parts() + B(9, y=3).parts()"),
    "arguments that constructors pass on": ("class Bay:\n    def __init__(self, x, width=1.5):\n        self.x, self.width = x, width\n"
        "class Window(Bay):\n    def __init__(self, x, open=True, **kwargs):\n        super().__init__(x, **kwargs)\n        self.open = open\n"
        "class Balcony(Window):\n    pass", "parts += [bar(b.x, b.width + b.open) for b in (Window(1), Balcony(2, open=False))]"),
    "fields by name before those by place": ("@dataclass\nclass Node:\n    y: float = field(default=2, kw_only=True)\n"
        "@dataclass\nclass Rod(Node):\n    x: float\n    size: float = .5", "parts += [bar(r.x, r.y, r.size) for r in (Rod(1), Rod(2, .7, y=5))]"),
    "items up to an IndexError": ("class Row:\n    def __init__(self, n):\n        self.n = n\n    def __getitem__(self, i):\n"
        "        if not 0 <= i < self.n:\n            raise IndexError(i)\n        return i * i", "parts += [bar(x, i) for i, x in enumerate(Row(4))]"),
    "the name of a type in an exception": ("def size(x):\n    if x < 0:\n        raise ValueError(f'{type(x).__name__} below 0')\n    return x",
        "parts.append(bar(size(2)))"),
    "a class that nothing uses": ("class Grid(dict):\n    pass", "parts.append(bar(1))"),
    "the same import twice": ("import numpy as np", "parts.append(bar(*np.array([1, 2]) * .5))"),
    "masks in place": ("", "keep = np.ones(5, dtype=bool)\nkeep[1] = False\nkeep &= np.arange(5) < 4\n"
        "parts += [bar(x) for x in np.arange(5)[keep]] + [bar(int(keep.sum()), 1)]"),
    "operators by the type of their operand": (POSE, "here = Pose()\nfor i in range(3):\n"
        "    here = here @ Pose.turn(.3) @ Pose.at(x=1)\n    parts.append(here @ bar(0))\n"
        "parts.append(bar(*(here @ np.array([1, 2, 3]))[:2]))"),
    "products of vectors and numbers": (PRODUCTS, "v = Vec(1, 2)\nw = v * 2 * .5 + v\nparts.append(bar(v * w, (w * v * 3) / 2))\n"
        "parts.append(bar((2 * v).x))"),
    "a parameter named as a constant": ("SIZES = [1, 2, 3]\n\n@register()\ndef row(sizes: int = 2) -> Shape:\n"
        "    return concat_shapes(*[bar(k, size=SIZES[k % 3]) for k in range(sizes)])",
        "parts += [library_call('row', sizes=4), library_call('row')]"),
    "the class of an object": ("class Hex:\n    def __init__(self, q, r):\n        self.q, self.r = q, r\n    def moved(self, dq):\n"
        "        return type(self)(self.q + dq, self.r)\n    def twin(self):\n        return self.__class__(self.r, self.q)",
        "h = Hex(1, 2).moved(3).twin()\nparts.append(bar(h.q, h.r))"),
    "beginnings and ends of texts": ("P = ParamSpec('P')", "words = ['to_a', 'b_x', 'to_']\n"
        "parts += [bar(len(w.removeprefix('to_')), len(w.removesuffix('_x'))) for w in words]"),
    "members that are texts or numbers": (MEMBERS, "parts += [bar(f.height) for f in Fill] + [bar(Floor.HIGH.above(), Floor(1).above())]\n"
        "for f in Fill:\n    if f == 'full' or f in ('none', 'empty'):\n        parts.append(bar({'empty': 7, 'full': 8}[f], WIDTHS.get(f, 1)))\n"
        "for k in range(Floor.HIGH):\n    parts.append(bar(Floor.HIGH * k, [5, 6, 7, 8][Floor.HIGH]))"),
    "data classes in order": ("@dataclass(order=True)\nclass P:\n    a: float\n    b: float = 1", "ps = [P(1 + (i * 3) % 4) for i in range(4)]\n"
        "for p in sorted(ps, reverse=True):\n    parts.append(bar(p.a, p.b))\nparts.append(bar(min(ps).a, max(P(2, 3), P(2, 5)).b))"),
    "fields of a frozen class": ("@dataclass(frozen=True)\nclass Box:\n    w: float\n    area: float = field(init=False)\n"
        "    def __post_init__(self):\n        object.__setattr__(self, 'area', self.w * 2)", "parts.append(bar(Box(3).area))"),
    "operators in place of their own": ("class Bag:\n    def __init__(self):\n        self.n = 0\n    def __iadd__(self, k):\n        self.n += k\n        return self",
        "b = Bag()\nfor i in range(4):\n    b += i\nparts.append(bar(b.n))"),
    "progress": ("from tqdm import tqdm", "for i in tqdm(range(3)):\n    parts.append(bar(i))"),
    "a diagonal": ("", "d = np.ones((3, 3))\nnp.fill_diagonal(d, 5)\nparts += [bar(x, y) for x, y, _ in d]"),
    "a new first axis": ("", "a = np.array([[1., 2], [4, 6]])\nparts += [bar(*x) for x in (a[None] - a[:, None]).sum(axis=0)]"),
    "an index of an array by its name": ("", "a = np.array([[1., 2], [4, 6]])\nfor idx in np.ndindex(2, 2):\n    parts.append(bar(a[idx], idx[0]))"),
    "a union of many sets": ("", "cells = reduce(operator.or_, ({(i, 0), (0, i)} for i in range(3)))\nparts += [bar(x, y) for x, y in sorted(cells)]"),
    "counts of a table's values": ("from collections import Counter", "kinds = {1: 'a', 2: 'b'}\nkinds[3] = 'a'\nfor k, n in sorted(Counter(kinds.values()).items()):\n    parts.append(bar(n, len(k)))"),
    "managers that are left early": ("from contextlib import contextmanager\nclass Pen:\n    def __init__(self):\n        self.stack = [0]\n"
        "    @contextmanager\n    def at(self, x):\n        self.stack.append(self.stack[-1] + x)\n        try:\n            yield len(self.stack)\n"
        "        finally:\n            self.stack.pop()\n"
        "def places(pen, xs):\n    found = []\n    for x in xs:\n        with pen.at(x) as depth:\n            if x < 2:\n                continue\n"
        "            found.append((pen.stack[-1], depth))\n            if x > 5:\n                break\n"
        "    with pen.at(.5):\n        if len(found) > 2:\n            return found, pen.stack[-1]\n    return found, -1",
        "pen = Pen()\nwith pen.at(10):\n    found, last = places(pen, range(9))\nparts += [bar(x, y) for x, y in found] + [bar(last, len(pen.stack))]\n"
        "found, last = places(pen, [3])\nparts += [bar(last, len(pen.stack), .5)]"),
    "a method that yields and draws, as the loop does": ("@dataclass\nclass Oak:\n    rng: object\n    depth: int = 3\n    def grow(self, x, level=0):\n"
        "        yield x, level\n        if level >= self.depth:\n            return\n        for k in range(2):\n"
        "            yield from self.grow(x + self.rng.uniform(-1, 1), level + 1)",
        "rng = random.Random(3)\nfor x, y in Oak(rng).grow(0.0):\n    parts.append(bar(x, y, .5 + rng.random()))"),
    "arguments fixed of a method of what is made there": ("import random", "shake = partial(random.Random(4).uniform, -1, 1)\nparts += [bar(shake(), shake()) for _ in range(3)]"),
    "a module as a parameter": ("import random\ndef shaken(x, amount, rng=random):\n    return x + rng.uniform(-amount, amount)",
        "shake = partial(shaken, amount=.1)\nparts += [bar(shake(x), shaken(1, .2)) for x in range(3)]"),
    "what is computed of all numbers, up to a limit": ("width = 2.0",
        "for x in itertools.takewhile(lambda w: w > .5, (width - .3 * k for k in itertools.count())):\n    parts.append(bar(x))"),
    "a default of a field that the class completes": ("@dataclass\nclass Mill:\n    height: float = 3\n    sail: float = field(default=0.0, repr=False)\n"
        "    def __post_init__(self):\n        self.sail = self.sail or self.height / 2", "parts += [bar(m.height, m.sail) for m in (Mill(), Mill(sail=1))]"),
    "a constant text of JSON": ("import json", "for row in json.loads('[{\"x\": 1, \"on\": true}, {\"x\": 2.5, \"on\": null}]'):\n"
        "    parts.append(bar(row['x'], 1 if row['on'] else 2))"),
    "items as a key": ("", "sizes = [3, 9, 4]\nparts.append(bar(max(range(3), key=sizes.__getitem__), len(string.capwords('a bc'))))"),
    "what tells people": ("import sys\nsys.setrecursionlimit(5000)", "print('a part', file=sys.stderr)\nparts.append(bar(1))"),
    "a log": ("import logging\nlog = logging.getLogger('a')", "log.info('%d parts', len(parts))\nparts.append(bar(1))"),
}  # fmt: skip


@pytest.mark.parametrize("name", LOWERED)
def test_python_is_translated_and_equal(name: str) -> None:
    before, body = LOWERED[name]
    lines = "\n".join(f"    {line}" for line in body.split("\n"))
    code = f"{HEAD}{before}\n\n@register()\ndef scene() -> Shape:\n    parts = []\n{lines}\n    return concat_shapes(*parts)\n"
    translation = SESSION.transpile(Source("lowered.py", code))
    assert translation.ok, told(translation.diagnostics)
    evaluated = SESSION.evaluate(Source("lowered.scene", translation.text))
    assert evaluated.scene is not None, f"{told(evaluated.diagnostics)}\n{translation.text}"
    with contextlib.redirect_stdout(io.StringIO()):
        expected = flatten(code)
    assert first_difference(flattened(evaluated.scene), expected) is None, translation.text
    assert "Evaluated from Python" not in translation.text


OTHER = {
    "an attribute of a class that changes": ("class Pen:\n    width = 1\n    def __init__(self, k):\n        if k > 1:\n"
        "            self.width = k", "Pen.width = 2\nparts += [bar(Pen.width), bar(Pen(3).width, 1)]"),
    "draws while it iterates": ("class Wind:\n    def __iter__(self):\n        for i in range(3):\n            yield np.random.uniform(0, 9)",
        "for x in Wind():\n    parts.append(bar(x, np.random.uniform(0, 9)))"),
    "operators in place": (VECTOR, "v = Vec(1, 2)\nfor i in range(3):\n    v += Vec(i, 1)\n    parts.append(bar(v.x, v.y))"),
    "a stream that a generator shares": ("def g():\n    for i in range(9):\n        yield i",
        "it = g()\nparts += [bar(x) for x in itertools.islice(it, 2)] + [bar(x, 1) for x in itertools.islice(it, 2)]"),
    "a name that is assigned again": ("", "k = 1\nat = partial(bar, y=k)\nk = 5\nparts += [at(1), at(2)]"),
    "an alternative constructor of a derived class": ("class A:\n    x = 1\n    @classmethod\n    def of(cls):\n        return cls()\n"
        "class B(A):\n    x = 2", "parts.append(bar(B.of().x))"),
    "factories before what a data class does last": ("@dataclass\nclass Post:\n    xs: list = field(default_factory=list)\n"
        "    def __post_init__(self):\n        self.xs.append(4)", "parts.append(bar(Post().xs[0]))"),
    "a protocol in a test": ("from typing import runtime_checkable\n@runtime_checkable\nclass Sized(Protocol):\n    def size(self): ...\n"
        "class A:\n    def size(self):\n        return 3", "if isinstance(A(), Sized):\n    parts.append(bar(1))\nparts.append(bar(2))"),
    "a log with an effect": ("import logging\ndef count():\n    SEEN.append(1)\n    return 1\nSEEN = []",
        "logging.info('%d', count())\nparts.append(bar(len(SEEN)))"),
    "a property of what a call gives": ("SEEN = []\nclass Pen:\n    def __init__(self):\n        self._x = 1\n    @property\n    def x(self):\n"
        "        return self._x\n    @x.setter\n    def x(self, value):\n        self._x = value\nPEN = Pen()\ndef pen():\n    SEEN.append(1)\n    return PEN",
        "pen().x += 2\nparts.append(bar(PEN.x, len(SEEN)))"),
    "a generator with parameters called items": ("def steps(items, limit):\n    k = 0\n    while True:\n        yield items[k % limit]\n        k += 1",
        "parts += [bar(x, i) for i, x in enumerate(itertools.islice(steps([3, 5, 8], 2), 5))]"),
    "own names of library functions": ("pairwise = 5\ndef mean(x):\n    return x + 1",
        "for a, b in itertools.pairwise([1, 4, 9]):\n    parts.append(bar(a, mean(b)))\nparts.append(bar(statistics.mean([1, 5]), pairwise))"),
}  # fmt: skip


@pytest.mark.parametrize("name", OTHER)
def test_what_is_not_the_same_is_not_lowered(name: str) -> None:
    before, body = OTHER[name]
    lines = "\n".join(f"    {line}" for line in body.split("\n"))
    code = f"{HEAD}{before}\n\n@register()\ndef scene() -> Shape:\n    parts = []\n{lines}\n    return concat_shapes(*parts)\n"
    translation = SESSION.transpile(Source("other.py", code))
    assert translation.ok, told(translation.diagnostics)
    evaluated = SESSION.evaluate(Source("other.scene", translation.text))
    assert evaluated.scene is not None, f"{told(evaluated.diagnostics)}\n{translation.text}"
    assert first_difference(flattened(evaluated.scene), flatten(code)) is None, translation.text
