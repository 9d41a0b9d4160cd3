"""Modern Python that is rewritten, and translated with its loops and parameters: nothing of these programs is evaluated."""

from __future__ import annotations

import re

import pytest

from scenelang.grammar.datum import Source
from scenelang.session.session import Session
from transpile.cases import first_difference, flattened, told
from transpile.reference_model import flatten

SESSION = Session()
HEAD = """from __future__ import annotations
from helper import *
import math, random, itertools, functools
import numpy as np
from dataclasses import dataclass, field, replace
from typing import NamedTuple, Iterator
from functools import reduce, lru_cache, partial, cached_property
from itertools import accumulate, chain, combinations, groupby, islice, pairwise, product, takewhile
def box(x, y=0.0, z=0.0, s=1.0):
    return transform_shape(primitive_call('cube', shape_kwargs={'scale': s}), translation_matrix((x, y, z)))
"""
ROOT = """
@register()
def root(n: int = 4, size: float = 1.0) -> Shape:
"""

# What stands before the root, and the body of the root.
PROGRAMS = {
    "first of a cycle": (
        "",
        """    colors = islice(itertools.cycle([0.5, 1.0, 1.5]), n)
    return concat_shapes(*[box(2 * k, 0.0, 0.0, s) for k, s in enumerate(colors)])""",
    ),
    "repr": (
        """class A:
    def __init__(self, x): self.x = x
    def __repr__(self): return f"A({self.x})"
    def __str__(self): return f"<{self.x}>"
""",
        """    a = [A(i) for i in range(n)]
    return concat_shapes(*[box(k.x) for k in a])""",
    ),
    "setter": (
        """class A:
    def __init__(self, x): self._x = x
    @property
    def x(self): return self._x
    @x.setter
    def x(self, v): self._x = max(0, v)
""",
        """    a = A(1); a.x = n; a.x += 1
    return box(a.x)""",
    ),
    "setitem": (
        """class Grid:
    def __init__(self, w): self.cells = {}; self.w = w
    def __setitem__(self, k, v): self.cells[k] = v
    def __getitem__(self, k): return self.cells.get(k, 0)
    def __contains__(self, k): return k in self.cells
""",
        """    g = Grid(n)
    for i in range(n): g[i, i * 2] = i + 1
    return concat_shapes(*[box(i, g[i, i * 2]) for i in range(n) if (i, i * 2) in g])""",
    ),
    "cachedprop": (
        """class A:
    def __init__(self, n): self.n = n
    @cached_property
    def pts(self):
        out = []
        for i in range(self.n): out.append((i, i * i))
        return out
""",
        """    a = A(n)
    return concat_shapes(*[box(x, y) for x, y in a.pts])""",
    ),
    "replace": (
        """@dataclass(frozen=True)
class S:
    w: float = 1.0
    h: float = 2.0
    tags: tuple = ()
""",
        """    s = S(); t = replace(s, h=size * 3)
    return concat_shapes(box(s.w, s.h), box(t.w, t.h))""",
    ),
    "deffactory": (
        """@dataclass
class Node:
    x: float
    kids: list[Node] = field(default_factory=list)
    def add(self, x):
        k = Node(x); self.kids.append(k); return k
    def walk(self):
        yield self
        for k in self.kids: yield from k.walk()
""",
        """    r = Node(0); a = r.add(1); a.add(2); r.add(3)
    return concat_shapes(*[box(v.x, i) for i, v in enumerate(r.walk())])""",
    ),
    "fluent": (
        """class B:
    def __init__(self): self.parts = []; self.y = 0.0
    def add(self, h):
        self.parts.append(box(0, self.y + h / 2, s=h)); self.y += h
        return self
    def build(self): return concat_shapes(*self.parts)
""",
        """    return B().add(1).add(size).add(.5).build()""",
    ),
    "walrus": (
        "",
        """    out = []
    i = 0
    while (k := i * i) < 20:
        out.append(box(k)); i += 1
    if (m := len(out)) > 3: out.append(box(m, 5))
    return concat_shapes(*out)""",
    ),
    "lru": (
        """@lru_cache(maxsize=None)
def fib(n): return n if n < 2 else fib(n - 1) + fib(n - 2)
""",
        """    return concat_shapes(*[box(fib(i)) for i in range(n + 4)])""",
    ),
    "groupby": (
        "",
        """    out = []
    for k, g in groupby("aabbbc"):
        out.append(box(ord(k) - 97, len(list(g))))
    return concat_shapes(*out)""",
    ),
    "tryx": (
        """def safe(d, k):
    try:
        return d[k]
    except KeyError:
        return 9
""",
        """    return concat_shapes(box(safe({'a': 1}, 'a')), box(safe({'a': 1}, 'b')))""",
    ),
    "abc": (
        """from abc import ABC, abstractmethod
class Sh(ABC):
    @abstractmethod
    def make(self): ...
    @property
    @abstractmethod
    def w(self): ...
    def placed(self, x): return transform_shape(self.make(), translation_matrix((x * self.w, 0, 0)))
class C1(Sh):
    w = 2.0
    def make(self): return box(0)
class C2(Sh):
    def __init__(self, k): self.k = k
    @property
    def w(self): return self.k
    def make(self): return box(0, s=self.k)
""",
        """    items: list[Sh] = [C1(), C2(3.0)]
    return concat_shapes(*[it.placed(i + 1) for i, it in enumerate(items)])""",
    ),
    "mixin": (
        """class Col:
    color = (1, 0, 0)
    def tint(self, k): return tuple(c * k for c in self.color)
class Sz:
    def size(self): return 2.0
class Th(Col, Sz):
    def make(self): return primitive_call('cube', color=self.tint(.5), shape_kwargs={'scale': self.size()})
""",
        """    return Th().make()""",
    ),
    "superkw": (
        """class A:
    def __init__(self, w, *, h=1.0): self.w, self.h = w, h
    def area(self): return self.w * self.h
class B(A):
    def __init__(self, d, **kw):
        super().__init__(**kw); self.d = d
    def area(self): return super().area() * self.d
""",
        """    return box(B(3, w=2, h=size).area())""",
    ),
    "registry": (
        """MAKERS = {}
def maker(name):
    def deco(fn):
        MAKERS[name] = fn
        return fn
    return deco
@maker('a')
def mk_a(s): return box(1, s=s)
@maker('b')
def mk_b(s): return box(2, s=s)
""",
        """    return concat_shapes(*[MAKERS[k](size) for k in ('a', 'b')])""",
    ),
    "wrapsdeco": (
        """def twice(fn):
    @functools.wraps(fn)
    def inner(*args, **kw):
        s = fn(*args, **kw)
        return concat_shapes(s, transform_shape(s, translation_matrix((0, 5, 0))))
    return inner
@twice
def thing(x, s=1.0): return box(x, s=s)
""",
        """    return thing(2, s=size)""",
    ),
    "genfib": (
        """def fib():
    a, b = 0, 1
    while True:
        yield a
        a, b = b, a + b
""",
        """    return concat_shapes(*[box(v, i) for i, v in zip(range(n), fib())], *[box(v, 9) for v in islice(fib(), 3)], *[box(v, 7) for v in takewhile(lambda v: v < 10, fib())])""",
    ),
    "npargs": (
        "",
        """    p = np.array([[0, 0, 0], [1, 2, 3], [4, 5, 6.0]])
    c = p.mean(axis=0); d = np.diff(p, axis=0); l = np.linalg.norm(d, axis=1); cum = np.concatenate([[0], np.cumsum(l)])
    i = int(np.argmax(l)); t = np.interp(2.0, cum, p[:, 1])
    return concat_shapes(box(*c), *[box(v, 2) for v in cum], box(i, t))""",
    ),
    "npmask": (
        "",
        """    a = np.arange(10)
    b = a[a % 2 == 0]
    c = np.where(a > 4, 1.0, 0.0)
    d = a.reshape(2, 5)
    return concat_shapes(*[box(int(v)) for v in b], box(c.sum(), d[1, 2], d.shape[1]), *[box(int(v), 3) for v in d[:, 0]], box(d.T[1][1], 4))""",
    ),
    "nprng": (
        "",
        """    rng = np.random.default_rng(42)
    pts = rng.uniform(-1, 1, size=(n, 3))
    order = rng.permutation(n)
    k = rng.integers(0, 5)
    c = rng.choice(['a', 'b'])
    return concat_shapes(*[box(*p) for p in pts], *[box(int(i), 5) for i in order], box(int(k), 8 if c == 'a' else 9))""",
    ),
    "starargs": (
        """def union(*shapes, gap=0.0):
    out = []
    for i, s in enumerate(shapes):
        out.append(transform_shape(s, translation_matrix((i * gap, 0, 0))))
    return concat_shapes(*out)
""",
        """    a, *rest = [box(i) for i in range(n)]
    kw = {'gap': size}
    return union(a, *rest, **kw)""",
    ),
    "deque": (
        """from collections import deque, OrderedDict, defaultdict
def bfs(g, s):
    q = deque([s]); dist = {s: 0}
    while q:
        v = q.popleft()
        for w in g[v]:
            if w not in dist:
                dist[w] = dist[v] + 1; q.append(w)
    return dist
""",
        """    return concat_shapes(*[box(k, v) for k, v in bfs({0: [1, 2], 1: [3], 2: [3], 3: []}, 0).items()])""",
    ),
    "strenum": (
        """from enum import StrEnum, Enum
class M(StrEnum):
    WOOD = 'wood'
    STONE = 'stone'
COL = {M.WOOD: (.5, .3, .1), M.STONE: (.5, .5, .5)}
""",
        """    return concat_shapes(*[primitive_call('cube', color=COL[m], shape_kwargs={'scale': len(m) + (m == 'wood')}) for m in M])""",
    ),
    "opmix": (
        """@dataclass(frozen=True)
class V:
    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    def __add__(self, o): return V(self.x + o.x, self.y + o.y, self.z + o.z)
    def __sub__(self, o): return V(self.x - o.x, self.y - o.y, self.z - o.z)
    def __mul__(self, k): return V(self.x * k, self.y * k, self.z * k)
    __rmul__ = __mul__
    def __neg__(self): return self * -1
    def __iter__(self): return iter((self.x, self.y, self.z))
    def __abs__(self): return math.sqrt(sum(c * c for c in self))
""",
        """    a, b = V(1, 2, 3), V(4, 5, 6)
    pts = [a + (b - a) * (i / n) for i in range(n)]
    return concat_shapes(*[transform_shape(box(0), translation_matrix(tuple(p))) for p in pts], box(*(2 * -a)), box(abs(b)), box(*sum(pts, V())))""",
    ),
    "itproduct": (
        "",
        """    return concat_shapes(*[box(i, j, k) for i, j, k in product(range(2), repeat=3)], *[box(a, b, 9) for a, b in combinations(range(n), 2)], *[box(i, 4) for i in chain(range(2), [5])], *[box(b - a, 6) for a, b in pairwise([1, 3, 7])], *[box(v, 8) for v in accumulate([1, 2, 3])])""",
    ),
    "sortedkey": (
        "",
        """    xs = sorted([(i * 7) % 5 for i in range(n)], key=lambda v: -v, reverse=True)
    ys = sorted({'b': 2, 'a': 1}.items(), key=lambda kv: kv[1])
    return concat_shapes(*[box(i, x) for i, x in enumerate(xs)], *[box(v, 9) for k, v in ys])""",
    ),
    "ctxclass": (
        """class Frame:
    def __init__(self): self.stack = [np.eye(4)]; self.out = []
    def push(self, m): self.stack.append(self.stack[-1] @ m)
    def pop(self): self.stack.pop()
    def emit(self, s): self.out.append(transform_shape(s, self.stack[-1]))
""",
        """    f = Frame()
    for i in range(n):
        f.push(translation_matrix((1, i, 0))); f.emit(box(0, s=size))
    f.pop(); f.emit(box(0))
    return concat_shapes(*f.out)""",
    ),
    "turtle": (
        """@dataclass
class Turtle:
    pos: np.ndarray = field(default_factory=lambda: np.zeros(3))
    heading: float = 0.0
    def forward(self, d):
        start = self.pos.copy()
        self.pos = self.pos + d * np.array([math.cos(self.heading), 0, math.sin(self.heading)])
        return start, self.pos
    def turn(self, a): self.heading += math.radians(a)
""",
        """    t = Turtle(); out = []
    for ch in "FF+F-F":
        if ch == 'F':
            a, b = t.forward(size)
            out.append(primitive_call('cylinder', shape_kwargs={'radius': .1, 'p0': tuple(a), 'p1': tuple(b)}))
        elif ch == '+': t.turn(60)
        else: t.turn(-60)
    return concat_shapes(*out)""",
    ),
    "maze": (
        """def maze(w, h, seed):
    rng = random.Random(seed)
    seen = {(0, 0)}; stack = [(0, 0)]; walls = set()
    while stack:
        x, y = stack[-1]
        opts = [(x + dx, y + dy) for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1)) if 0 <= x + dx < w and 0 <= y + dy < h and (x + dx, y + dy) not in seen]
        if not opts:
            stack.pop(); continue
        nxt = rng.choice(opts)
        seen.add(nxt); stack.append(nxt); walls.add(((x, y), nxt))
    return walls
""",
        """    return concat_shapes(*[box((a[0] + b[0]) / 2, (a[1] + b[1]) / 2) for a, b in sorted(maze(n, 3, 5))])""",
    ),
    "perlin": (
        """def fade(t): return t * t * t * (t * (t * 6 - 15) + 10)
def noise(seed, w, h):
    rng = np.random.default_rng(seed)
    grid = rng.random((h + 1, w + 1))
    def at(x, y):
        i, j = int(x), int(y)
        u, v = fade(x - i), fade(y - j)
        a = grid[j, i] * (1 - u) + grid[j, i + 1] * u
        b = grid[j + 1, i] * (1 - u) + grid[j + 1, i + 1] * u
        return a * (1 - v) + b * v
    return at
""",
        """    f = noise(3, 4, 4)
    return concat_shapes(*[box(x, f(x * .7, z * .7), z) for x in range(n) for z in range(n)])""",
    ),
    "statemach": (
        """from enum import Enum
class S(Enum):
    RED = 'red'
    GREEN = 'green'
    YELLOW = 'yellow'
    def next(self):
        return {S.RED: S.GREEN, S.GREEN: S.YELLOW, S.YELLOW: S.RED}[self]
    @property
    def rgb(self): return {'red': (1, 0, 0), 'green': (0, 1, 0), 'yellow': (1, 1, 0)}[self.value]
""",
        """    s = S.RED; out = []
    for i in range(n):
        out.append(transform_shape(primitive_call('sphere', color=s.rgb, shape_kwargs={'radius': .5}), translation_matrix((i, 0, 0))))
        s = s.next()
    return concat_shapes(*out)""",
    ),
    "visitor": (
        """class Expr: pass
@dataclass
class Num(Expr):
    v: float
@dataclass
class Add(Expr):
    l: Expr
    r: Expr
def ev(e: Expr) -> float:
    match e:
        case Num(v): return v
        case Add(l, r): return ev(l) + ev(r)
        case _: raise TypeError(e)
""",
        """    return box(ev(Add(Num(1), Add(Num(2), Num(size)))))""",
    ),
    "bst": (
        """class Tree:
    def __init__(self, v): self.v, self.l, self.r = v, None, None
    def insert(self, v):
        if v < self.v:
            if self.l is None: self.l = Tree(v)
            else: self.l.insert(v)
        else:
            if self.r is None: self.r = Tree(v)
            else: self.r.insert(v)
    def __iter__(self):
        if self.l: yield from self.l
        yield self.v
        if self.r: yield from self.r
""",
        """    t = Tree(5)
    for v in [3, 8, 1, 4, 9]: t.insert(v)
    return concat_shapes(*[box(v, i) for i, v in enumerate(t)])""",
    ),
    "bezier": (
        """def bez(p, t):
    p = np.asarray(p, float); t = np.asarray(t)[:, None]
    return (1 - t)**3 * p[0] + 3 * (1 - t)**2 * t * p[1] + 3 * (1 - t) * t**2 * p[2] + t**3 * p[3]
""",
        """    pts = bez([(0, 0, 0), (1, 2, 0), (3, 2, 1), (4, 0, 0)], np.linspace(0, 1, n))
    return concat_shapes(*[primitive_call('cylinder', shape_kwargs={'radius': .1, 'p0': a, 'p1': b}) for a, b in zip(pts[:-1], pts[1:])])""",
    ),
    "voxel": (
        "",
        """    g = np.zeros((3, 3, 3), dtype=bool)
    g[1, 1, :] = True; g[:, 0, 0] = True
    return concat_shapes(*[box(int(x), int(y), int(z)) for x, y, z in np.argwhere(g)])""",
    ),
    "repeat": (
        "",
        """    return concat_shapes(*(box(*p) for p in zip(itertools.cycle([0, 1]), range(n), itertools.repeat(size))))""",
    ),
    "endless generator": (
        """def strobe(start, rng):
    x = start
    while True:
        x += rng.random()
        yield x, rng.uniform(0, 1)
""",
        """    rng = random.Random(3)
    out = []
    for x, y in strobe(0.0, rng):
        if x > n:
            break
        out.append(box(x, y, rng.random()))
    return concat_shapes(*out)""",
    ),
    "recursive generator": (
        """def grow(x, depth, rng):
    yield x, depth
    if depth:
        for k in range(2):
            yield from grow(x + rng.random(), depth - 1, rng)
""",
        """    rng = random.Random(n)
    out = []
    total = 0.0
    for x, depth in grow(0.0, 3, rng):
        if depth == 1:
            continue
        total += x
        out.append(box(x, rng.random(), total))
    return concat_shapes(*out)""",
    ),
    "context manager": (
        """from contextlib import contextmanager
class Builder:
    def __init__(self):
        self.pose, self.out = np.eye(4), []
    @contextmanager
    def at(self, x=0.0, y=0.0):
        before = self.pose
        self.pose = before @ translation_matrix((x, y, 0))
        try:
            yield self
        finally:
            self.pose = before
    def add(self, s):
        self.out.append(transform_shape(primitive_call('cube', shape_kwargs={'scale': s}), self.pose))
class Count:
    def __init__(self, start): self.n = start
    def __enter__(self):
        self.n += 1
        return self
    def __exit__(self, *exc): self.n += 10
""",
        """    b = Builder()
    for i in range(n):
        with b.at(x=i), b.at(y=2.0) as c:
            c.add(size)
    with Count(1) as k:
        b.add(k.n)
    b.add(k.n)
    return concat_shapes(*b.out)""",
    ),
    "match": (
        """class Box(NamedTuple):
    w: float
    h: float
@dataclass
class Ball:
    r: float
def width(item):
    match item:
        case Box(w, h) if w > h: return w
        case Box(h=h): return h * 2
        case Ball(r=r): return r
        case [a, *rest]: return a + len(rest)
        case {'kind': 'k', 'size': s}: return s
        case 7 | 8: return 0.25
        case str() as text: return len(text)
        case _: return 0.5
""",
        """    items = [Box(3.0, 1.0), Box(1.0, 2.0), Ball(size), [2, 5, 6], {'kind': 'k', 'size': 4}, 8, "abc", None]
    return concat_shapes(*[box(i, s=width(item)) for i, item in enumerate(items)])""",
    ),
    "enumeration": (
        """from enum import Enum, IntEnum, Flag, auto
class Planet(Enum):
    EARTH = (1.0, 'blue')
    MARS = (.5, 'red')
    def __init__(self, radius, word): self.radius, self.word = radius, word
    @classmethod
    def largest(cls): return max(cls, key=lambda p: p.radius)
class Side(Flag):
    NORTH = auto()
    EAST = auto()
    BOTH = NORTH | EAST
class Level(IntEnum):
    LOW = 1
    HIGH = 3
""",
        """    out = [box(k, s=p.radius) for k, p in enumerate(Planet)]
    out += [box(9, s=Planet.largest().radius), box(len(Planet['MARS'].word), 1), box(4, s=Level.HIGH * 2 + Level(1))]
    for side in (Side.NORTH, Side.EAST, Side.BOTH):
        if Side.EAST in side: out.append(box(side.value, 5))
    return concat_shapes(*out)""",
    ),
    "namespace": (
        """from types import SimpleNamespace
from typing import TypedDict
class Spec(TypedDict, total=False):
    w: float
DEFAULTS: Spec = {'w': 2.0}
class Odd(ValueError):
    pass
""",
        """    s = SimpleNamespace(**(DEFAULTS | {'h': size}))
    if s.w < 0: raise Odd("negative")
    return box(s.w, s.h)""",
    ),
    "protocol": (
        """from typing import Protocol, runtime_checkable
@runtime_checkable
class Solid(Protocol):
    def volume(self) -> float: ...
class Brick:
    def volume(self): return 2.0
class Ghost:
    def weight(self): return 0.0
""",
        """    return concat_shapes(*[box(i, 1 if isinstance(k, Solid) else 2) for i, k in enumerate([Brick(), Ghost()])])""",
    ),
    "passed on": (
        """@dataclass
class Part:
    w: float
    h: float = 2.0
    color: tuple = (1, 0, 0)
    @classmethod
    def square(cls, w, **style): return cls(w=w, **style)
""",
        """    parts = [Part.square(1.0, color=(0, 1, 0)), Part.square(size)]
    return concat_shapes(*[transform_shape(primitive_call('cube', color=p.color), translation_matrix((p.w, p.h, 0))) for p in parts])""",
    ),
    "heap": (
        """import heapq
from collections import Counter
@dataclass(order=True)
class Event:
    time: float
    name: str = field(compare=False)
""",
        """    queue = []
    for i in range(n + 4):
        heapq.heappush(queue, Event((i * 7) % 5, "x" * i))
    out = []
    while queue:
        e = heapq.heappop(queue)
        out.append(box(e.time, len(e.name)))
    out += [box(k, ord(c) - 97) for c, k in Counter("hello world").most_common(2)]
    head, sep, tail = "a=5".partition("=")
    return concat_shapes(*out, box(int(tail), 9))""",
    ),
    "axes": (
        "",
        """    t = np.linspace(0, 1, n)
    pts = np.array([1.0, 2.0, 3.0]) * t[:, None] + np.c_[t, t * 2, np.zeros(n)]
    d = np.roll(pts, -1, axis=0) - np.roll(pts, 1, axis=0)
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    g = (pts[:, None, :] + d[None, :, :]).reshape(-1, 3) @ np.diag([1.0, 2.0, size])
    up = np.cross(d, [0.0, 1.0, 0.0])
    return concat_shapes(*[box(*p) for p in g], *[box(*p, s=np.ptp(t)) for p in up])""",
    ),
    "starred": (
        "",
        """    rows = [(1, 2, 3), (4, 5, 6.5)]
    return concat_shapes(*[box(e) for *_, e in rows], *[box(a, c) for a, *_, c in rows])""",
    ),
    "cycle": (
        "",
        """    out = []
    colors = itertools.cycle([1, 2, 3])
    for i, c in zip(range(n + 3), colors):
        out.append(box(i, c))
    return concat_shapes(*out, *[box(i, k) for i, k in zip([5, 6], itertools.count(2))])""",
    ),
    "longest": (
        "",
        """    rows = itertools.zip_longest([1.0, 2.0, 3.0][:n], [size], fillvalue=0.5)
    return concat_shapes(*[box(x, y) for x, y in rows])""",
    ),
    "getters": (
        """from operator import attrgetter, itemgetter, methodcaller
@dataclass
class P:
    x: float
    name: str
    def far(self, k): return self.x * k
""",
        """    ps = sorted([P(3, 'c'), P(n, 'b'), P(2, 'b')], key=attrgetter('name', 'x'))
    far = map(methodcaller('far', size), ps)
    pairs = sorted([(1, 5), (2, 3)], key=itemgetter(1, 0))
    return concat_shapes(*[box(p.x, f) for p, f in zip(ps, far)], *[box(a, b) for a, b in pairs])""",
    ),
    "keywords only": (
        """from dataclasses import KW_ONLY, astuple, asdict
@dataclass
class P:
    x: float = 0.5
    _: KW_ONLY
    y: float
    z: float = 3.0
""",
        """    ps = (P(y=n), P(2.0, y=size), P(1.0, y=n, z=9.0))
    p = ps[2]
    last = asdict(p)
    return concat_shapes(*[box(p.x, p.y, p.z) for p in ps], box(last['z']), *[box(*astuple(p)) for p in ps])""",
    ),
    "defaults of a named tuple": (
        """from collections import namedtuple
P = namedtuple('P', 'x y z', defaults=(1.0, 2.0))
""",
        "    return concat_shapes(*[box(p.x, p.y, p.z) for p in (P(n), P(2.0, size), P(1.0, z=9.0))])",
    ),
    "cases of a tuple": (
        "",
        """    out = []
    for i in range(n):
        a, b = i % 2, i
        match a, size:
            case 0, 1.0:
                y = 5.0
            case 1, _:
                y = 6.0
            case other, what:
                y = other + what
        match (b, a):
            case (a, b) if a > 1:
                x = a * 10 + b
            case x, y:
                x = x + y
        out.append(box(x, y, a + b))
    return concat_shapes(*out)""",
    ),
    "rest of a mapping": (
        """def item(d):
    match d:
        case {'kind': 'a', 'size': s, **rest}:
            return s + len(rest) + rest.get('q', 0)
        case {'kind': 'b'} | {'kind': 'c'}:
            return 7.0
        case {}:
            return 9.0
""",
        """    rows = [{'kind': 'a', 'size': size, 'q': 4}, {'kind': 'c'}, {}, {'kind': 'a', 'size': n}]
    return concat_shapes(*[box(item(d), i) for i, d in enumerate(rows)])""",
    ),
    "counters": (
        """from collections import Counter
from statistics import fmean
class Tally:
    def __init__(self): self.counts = Counter()
    def add(self, name, k=1):
        self.counts[name] += k
        return self
    def merge(self, other): self.counts.update(other)
""",
        """    t = Tally()
    t.add('a').add('b', n).add('a')
    t.merge(['b', 'c'])
    rows = Counter(i % 3 for i in range(10 + n))
    middle = fmean(k * size for k in rows.values())
    out = [box(i, k) for i, (name, k) in enumerate(sorted(t.counts.items()))]
    return concat_shapes(*out, *[box(x, k, middle) for x, k in rows.items()])""",
    ),
    "complex numbers": (
        """import cmath
def roots(n, r): return [cmath.rect(r, 2 * math.pi * k / n) for k in range(n)]
""",
        """    out = []
    for z in roots(n, size):
        w = (z * z + 0.5j - 1) * 2 / (1 + 1j)
        out.append(box(w.real, cmath.phase(z), w.imag, 0.1 + abs(z ** 2)))
    return concat_shapes(*out)""",
    ),
    "single dispatch": (
        """from functools import singledispatch, singledispatchmethod
@dataclass
class A:
    r: float
@dataclass
class B(A):
    t: float = 1.0
@singledispatch
def draw(x, k=1.0): raise TypeError(x)
@draw.register
def _(x: A, k=1.0): return box(x.r, k)
@draw.register(B)
def _(x, k=1.0): return box(x.r, k, x.t)
@draw.register
def _(x: list, k=1.0): return concat_shapes(*[draw(each, k) for each in x])
class Pen:
    @singledispatchmethod
    def line(self, what): raise TypeError
    @line.register
    def _(self, what: int): return box(what, 9)
    @line.register
    def _(self, what: str): return box(len(what), 8)
""",
        """    pen = Pen()
    return concat_shapes(draw(A(1.0)), draw(B(size), n), draw([A(2.0), B(n)]), pen.line(n), pen.line("abc"))""",
    ),
    "names that methods of values would take": (
        """class Point(NamedTuple):
    x: float
    y: float
    def size(self): return self.x + self.y
def point_size(p): return 5.0
""",
        """    table = {Point(1, 2): 0.5, Point(2, 3): 1.5}
    return concat_shapes(*[box(p.size(), table[p], point_size(p)) for p in (Point(1, 2), Point(2, 3))])""",
    ),
    "hooks of subclasses": (
        """class Base:
    registry = {}
    tag = ''
    def __init_subclass__(cls, /, key='', **kwargs):
        super().__init_subclass__(**kwargs)
        cls.tag = key
        Base.registry[key or cls.__name__.lower()] = cls
    def __init__(self, s): self.s = s
    def width(self): return self.s
class Foo(Base, key='f'):
    def width(self): return 2.0 * self.s
class Bar(Base):
    pass
""",
        """    kinds = sorted(Base.registry.items())
    return concat_shapes(*[box(k(size).width(), i, len(k(1).tag) + n) for i, (name, k) in enumerate(kinds)])""",
    ),
    "grids": (
        "",
        """    ys, xs = np.mgrid[0:n, 0:4]
    g, h = np.meshgrid(np.linspace(0, size, 3), np.arange(2), indexing='ij')
    i, j = np.indices((2, n))
    out = [box(x, y) for x, y in zip(xs.ravel(), ys.ravel())] + [box(a, b, 1) for a, b in zip(i.ravel(), j.ravel())]
    return concat_shapes(*out, *[box(g[i, j], h[i, j], 5) for i in range(3) for j in range(2)])""",
    ),
    "sums of products": (
        "",
        """    a = np.arange(6.0).reshape(2, 3)
    b = np.array([[1.0, 2.0, size], [0.0, 1.0, n]])
    c, d = np.einsum('ij,kj->ik', a, b), np.einsum('ij,ij->i', a, b)
    return concat_shapes(*[box(c[i, 0], c[i, 1], d[i] + np.einsum('ij->', a)) for i in range(2)])""",
    ),
    "frozen sets": (
        "",
        """    edges = {frozenset((0, 1)), frozenset((1, 0)), frozenset((1, n))}
    edges.add(frozenset((2, 3)) - {2} | {1})
    pairs = [(a, b) for a in range(6) for b in range(6) if frozenset((a, b)) in edges]
    return concat_shapes(*[box(a, b, len(edges), size) for a, b in pairs])""",
    ),
    "iterators": (
        """from itertools import count, cycle
ids = count(3, 2)
def number(): return next(ids)
def pairs(text):
    tokens = iter(text.split())
    for token in tokens:
        if token == ':':
            yield 9, float(next(tokens))
        else:
            yield float(token), 0
""",
        """    it = iter([1.0, 2.0, size, 4.0])
    turn = cycle('ab')
    first = next(it)
    out = [box(first, number(), ord(next(turn))) for _ in range(n)]
    while (x := next(it, None)) is not None:
        if x > 3: break
        out.append(box(x, number()))
    return concat_shapes(*out, *[box(x, y) for x, y in pairs('1 2 : 3 4')])""",
    ),
    "members by name": (
        """from enum import Enum, Flag, auto
class Kind(Enum):
    A = (1.0, 'x')
    B = (2.0, 'yy')
    def __init__(self, width, letter):
        self.width = width
        self.letter = letter
class F(Flag):
    X = auto(); Y = auto(); Z = auto()
def flags(text):
    out = F(0)
    for ch in text.upper():
        out |= F[ch]
    return out
""",
        """    out = []
    for i, name in enumerate('AB'):
        kind, wanted = Kind[name], flags('xz') if i else flags('y')
        out += [box(j, i, len(kind.letter), kind.width) for j, f in enumerate(F) if f in wanted]
    table = {Kind.A: size, Kind.B: n}
    return concat_shapes(*out, *[box(v, k.width) for k, v in table.items()])""",
    ),
    "values as keys": (
        """class P(NamedTuple):
    x: int
    y: int = 2
    def step(self, d): return P(self.x + d.x, self.y + d.y)
    @property
    def far(self): return abs(self.x) + abs(self.y)
@dataclass(frozen=True)
class Cell:
    row: int
    col: int
""",
        """    seen = {P(0, 1), P(n)}
    seen.add(P(1, 1).step(P(1, 1)))
    costs = {P(0, 1): 5.0, P(n): size}
    costs[P(x=0, y=1)] += 1
    cells = {Cell(i % 2, 0) for i in range(n)}
    low = min(P(3, 1), P(1, n), P(1))
    out = [box(a, b, len(seen)) for a in range(5) for b in range(3) if P(a, b) in seen]
    out += [box(p.x, p.far, costs[p]) for p in sorted(costs)] + [box(c.row, c.col) for c in [Cell(0, 0)] if c in cells]
    return concat_shapes(*out, box(low.y, len(cells), 1 if low == (1, 2) else 0))""",
    ),
    "classes as values": (
        """from abc import ABC, abstractmethod
@dataclass
class Building(ABC):
    width: float
    zone: str
    def __post_init__(self):
        if self.width <= 0: raise ValueError(self.width)
    @abstractmethod
    def top(self): ...
    def build(self): return concat_shapes(box(self.width, len(self.zone)), self.top())
class Tower(Building):
    def top(self): return box(self.width, 5)
class Hut(Building):
    def top(self): return box(self.width, 1)
""",
        """    out = []
    for i in range(n):
        zone = 'ab'[i % 2] * i
        out.append({'a': Tower}.get(zone[:1], Hut)(width=size + i, zone=zone).build())
    return concat_shapes(*out)""",
    ),
    "operators of objects that grow": (
        """import operator
class Part:
    def __add__(self, other): return Pile([self, other])
    def __len__(self): return 1
class Slab(Part):
    def __init__(self, x): self.x = x
    def shapes(self): return [box(self.x)]
class Pile(Part):
    def __init__(self, parts=()): self.parts = list(parts)
    def __add__(self, other): return Pile([*self.parts, other])
    def __len__(self): return sum(len(each) for each in self.parts)
    def __lshift__(self, x): return Pile([*self.parts, Slab(x)])
    def shapes(self): return [s for each in self.parts for s in each.shapes()]
@dataclass(frozen=True)
class Vec:
    x: float
    y: float
    def __add__(self, other): return Vec(self.x + other.x, self.y + other.y)
def path(n):
    here = Vec(0, 0)
    for k in range(n):
        yield here
        here += Vec(k, 1)
""",
        """    pile = Pile()
    for k in range(n): pile = pile + Slab(k * size)
    pile = pile << n
    both = reduce(operator.add, [Slab(1), Slab(2), pile])
    return concat_shapes(*both.shapes(), box(len(both), len(pile)), *[box(v.x, v.y) for v in path(n)])""",
    ),
    "managers that are methods": (
        """from contextlib import contextmanager
Offset = tuple[float, float]
class Canvas:
    def __init__(self): self.stack = [(0.0, 0.0)]; self.out = []
    @contextmanager
    def moved(self, *offsets: Offset):
        x, y = self.stack[-1]
        self.stack.append((x + sum(a for a, _ in offsets), y + sum(b for _, b in offsets)))
        try:
            yield self
        finally:
            self.stack.pop()
    def put(self, s=1.0):
        x, y = self.stack[-1]
        self.out.append(box(x, y, 0, s))
""",
        """    c = Canvas()
    with c.moved((1, 0), (0, 2)):
        c.put()
        for i in range(n):
            with c.moved((0, i)):
                c.put(size)
    c.put()
    return concat_shapes(*c.out)""",
    ),
    "generators that never end": (
        """from itertools import count, cycle
def squares(): yield from (k * k for k in count())
""",
        """    names = map(str.strip, ' a ; b;c '.split(';'))
    turn = islice(cycle([1, 2, 3]), 2, 2 + n)
    return concat_shapes(*[box(x, size) for x in islice(squares(), n)], *[box(ord(t) - 97, k) for t, k in zip(names, turn)])""",
    ),
}


@pytest.mark.parametrize("name", PROGRAMS)
def test_is_translated_with_its_parameters(name: str) -> None:
    before, body = PROGRAMS[name]
    code = f"{HEAD}{before}{ROOT}{body}\n"
    translation = SESSION.transpile(Source("modern.py", code))
    assert translation.ok, told(translation.diagnostics)
    assert "Evaluated from Python" not in translation.text
    assert "W808" not in told(translation.diagnostics)
    for name, value in (("n", 4), ("n", 5), ("size", 1.5)):
        python = re.sub(rf"({name}: \w+) = [\d.]+", rf"\1 = {value}", code, count=1)
        scene = SESSION.evaluate(Source("modern.scene", with_argument(translation.text, name, value)))
        assert scene.scene is not None, told(scene.diagnostics)
        assert first_difference(flattened(scene.scene), flatten(python)) is None, (name, value)


def with_argument(text: str, name: str, value: float) -> str:
    """Return a program with another value of a parameter of its root, which may have become one of the program."""
    text, count = re.subn(rf"^\(param {name} [^\s)]+", f"(param {name} {value}", text, flags=re.M)
    is_parameter = count == 0 and f"(:{name} " in text
    return text.replace('(scene "root")', f'(scene "root" :{name} {value})') if is_parameter else text
