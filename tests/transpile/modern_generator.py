"""Random programs in current Python from a grammar: `modern_program(seed)` gives the text of one.

The grammar is a table of templates by type; a hole such as ``{i}`` is an expression of the type whose letter it has:
i an integer, f a float, s a text, b a truth value, l a list of integers, t a tuple of integers, d a table from texts to
integers, z a set of integers, a an array of three numbers, g an iterable of integers, F a function of an integer, and
e a member of an enumeration.
"""

from __future__ import annotations

import random
import re

from transpile.generator import Writer

_HOLE = re.compile(r"\{([a-zA-Z])\}")
_LEAVES = {
    "i": "0|1|2|3|5|7|-1|-4|10|len(WORDS)|N|Kind.B.value|Level.HIGH|Base.count|True + 1",
    "f": "0.5|1.5|-0.25|2.0|math.pi|1e-3|N / 4|3.0|-0.0",
    "s": "'a'|'oak'|''|'Red fox'|'x,y'|Kind.A.name|WORDS[1]|'tab\\tend'",
    "b": "True|False|N > 2|bool(WORDS)|not N",
    "l": "[]|[1]|[3, 1, 2]|list(range(4))|[0] * 3|[*TABLE.values()]|list(NUMBERS)",
    "t": "()|(1,)|(4, 2, 9)|NUMBERS|(0, 0)|Point(1, 2)",
    "d": "{}|{'a': 1}|dict(TABLE)|{'b': 2, 'a': 5}|dict(x=1, y=2)|{k: len(k) for k in WORDS}",
    "z": "set()|{1, 2}|{3, 3, 5}|set(NUMBERS)|frozenset({2})",
    "a": "np.zeros(3)|np.ones(3)|np.arange(3)|np.array([1.5, -2, 0.25])|np.linspace(0, 1, 3)|np.eye(3)[1]",
    "g": "range(4)|count_to(3)|(x for x in NUMBERS)|iter([5, 6])|islice(naturals(), 3)|map(abs, NUMBERS)|Deck(3, 4)",
    "F": "abs|twice|(lambda q: q + 1)|make_adder(3)|partial(mixed, 2)|Scaler(2)|math.floor",
    "e": "Kind.A|Kind.B|Kind['C']|Kind(2)|list(Kind)[0]",
}
_SIMPLE = {
    "i": "N + 0|3|-7|len(WORDS)|Base.count|fib(6)|twice(4)", "f": "0.5|math.pi|N / 4|-2.75|lerp(1, 2, 0.3)",
    "s": "WORDS[1]|Kind.A.name|WORDS[N % 3]", "l": "[1, 2]|list(NUMBERS)|WORDS|nested(2)", "d": "TABLE|vars(Box(1, 2))",
    "b": "N > 2|not WORDS|True", "e": "Kind.B|Level.LOW|max(Level)",
}  # fmt: skip
_GRAMMAR = {
    "i": """
{i} + {i}|{i} - {i}|{i} * {i} % 97|{i} // 3|{i} % 5|-{i}|abs({i})|{i} // (abs({i}) + 1)|{i} & 7|{i} | 2|{i} ^ 5|~{i}
len({l})|len({s})|len({d})|sum({l})|max({l}, default=0)|min({t} or (7,))|{l}.count({i})|{s}.count('a')|{s}.find('o')
int({f})|round({f})|math.floor({f})|math.ceil({f})|int({b})|{i} if {b} else {i}|{b} and {i} or {i}|({i} or {i})
{d}.get({s}, {i})|sum({d}.values())|len({z})|sum({z})|{F}({i})|sum(x * 2 for x in {g})|next({g!r}, {i})
first({g}, {i})|reduce(lambda p, q: p * 3 + q, {l}, {i})|sum(1 for _ in {g})|{e}.value|Level({i} % 2 + 1)|Level.LOW + {i}
tally({i}, {i})|tally({i}, k={i})|tally(*{t}, k={i})|tally(*{l}, **{d})|Box({i}, {i}).m({i})|Crate({i}).m({i})
Crate({i}, lid={i}).total|Box({i}, {i}).area|Box({i}, {i}) @ Box({i}, {i})|(Box({i}, 1) + Box(2, {i})).area
Box.unit({i}).area|Crate.unit({i}).m(2)|len(Deck(*{l}))|Deck(*{l}, {i})[-1]|sum(Deck(*{l}))|Scaler({i})({i})
describe({i})|describe({l})|describe({d})|describe({t})|describe({e})|describe(Box({i}, {i}))|safe({i}, {i})
(lambda *a, **k: len(a) + len(k))(*{t}, **{d})|(lambda a, b=2: a * b)({i})|ord({s}[:1] or 'z')|divmod({i}, 7)[1]
int(np.sum({a} > 0))|int({a}.argmax())|int(np.argsort({a})[0])|len(np.unique({a}))|fib({i} % 8)|bisect({l!s}, {i})
sorted({l} + [{i}])[0]|sorted({l} + [4], key=lambda v: (v % 3, -v))[-1]|[{i}, {i}][{b}]|({i}, {i})[{i} % 2]|int.bit_length({i})
(n := {i}) + n|max({i}, {i})|min({i}, {i}, key=abs)|pow({i}, 2, 13)|hash(({i}, {i})) % 2 * 0|int('{digits}') % 11
Point({i}, {i}).x|Point(y={i}, x=1).norm1()|Point({i}, 2)._replace(x={i}).x|len({d} | {d})|len({z} & {z})|sum({z} | {z})
heapq.nsmallest(1, {l} + [{i}])[0]|sum(accumulate({l}))|sum(x * y for x, y in zip({l}, {l}))|Counter({s})['a']
counter()|len(str({i}))|len(f'{{{i}:>5}}')|sum(map(int, str(abs({i}))))|sum(pairwise_diff({l}))""",
    "f": """
{f} + {f}|{f} * {f}|{f} - {i}|{i} / 4|{f} / (abs({f}) + 1)|math.sin({f})|math.sqrt(abs({f}))|float({i})|round({f}, 2)
abs({f})|{f} if {b} else {f}|max({f}, {f})|{a}.sum()|float({a}.mean())|{a}[1]|float(np.dot({a}, {a}))|math.hypot({f}, {i})
float(np.linalg.norm({a}))|sum([{f}, {f}])|{f} % 1|{f} // 0.5|lerp({f}, {f}, 0.25)|Box({i}, {i}).ratio|-{f}|{f} ** 2
statistics.mean({l} + [1])|float(f'{{{f}:.3f}}')|float(Fraction({i}, 7))|float(np.clip({f}, -1, 1))|math.fmod({f}, 3)
colorsys.hsv_to_rgb(abs({f}) % 1, 0.5, 1)[0]|float(np.interp({f}, [0, 1], [5, 9]))|math.dist((0, {i}), ({f}, 1))""",
    "s": """
{s} + {s}|{s} * ({i} % 3)|{s}.upper()|{s}.title()|{s}[::-1]|{s}[1:]|{s}[-2:]|str({i})|str({b})|str({l})|repr({s})|repr({t})
f'{{{i}}}'|f'{{{i}:04d}}'|f'{{{f}:.2f}}'|f'{{{s}:>6}}|'|f'{{{s}!r}}'|f'{{{i}:+d}}/{{{f}:8.3f}}'|f'{{{f}:e}}'|f'{{{i}:b}}'
'%d-%s' % ({i}, {s})|'{{}}:{{:>3}}'.format({s}, {i})|'{{0[0]}}'.format({l} + [1])|{s}.replace('o', '0')|{s}.strip('a ')
','.join(map(str, {l}))|''.join(sorted({s}))|{s}.split(',')[0]|{s}.partition(',')[2]|{s}.center(7, '*')|{s}.zfill(4)
{e}.name|str({e})|repr({e})|f'{{{e}}}'|str(Level.LOW)|str(Box({i}, 2))|repr(Crate({i}))|f'{{Box({i}, 1)!s:>12}}'|str({d})
str(Point({i}, {i}))|{s} if {b} else {s}|chr(97 + {i} % 26)|'x' if {s} else 'y'|hex({i})|type({i}).__name__|max({s}, {s})
str(sorted({z}))|re.sub('[aeiou]', '_', {s})|'-'.join(re.findall('[a-z]+', {s}))|textwrap.shorten({s}, 6)|kind_of({i})
kind_of({l})|kind_of({s})|kind_of({f})|kind_of({d})|kind_of(Box(1, 1))|kind_of(None)|attempt(lambda: {i} // {i})|{s}.casefold()
attempt(lambda: {l}[{i}])|attempt(lambda: {d}[{s}])|attempt(lambda: checked({i}))|attempt(lambda: int({s}))|Crate.__name__
'{{:,.1f}}'.format({i} * 1000.5)|f'{{{l}}}'|f'{{{d}!r}}'|str(Counter({s}).most_common(1))|str(Fraction({i}, 6))|ascii({s})
str({i} + 2j)|str({i} < 3)|f'{{{b}:d}}'|str(None)|{s}.swapcase()|{s}.expandtabs(4)|' '.join(w.capitalize() for w in {s}.split())""",
    "b": """
{i} < {i}|{i} == {i}|{f} >= {i}|{s} == {s}|{s} < {s}|{b} and {b}|{b} or {b}|not {b}|{i} in {l}|{s} in {d}|0 <= {i} < 4
{l} == {l}|{t} < {t}|{z} <= {z}|any(x > 1 for x in {g})|all({l})|isinstance({i}, int)|isinstance({f}, int)|{s}.startswith('a')
{e} is Kind.A|{e} == {e}|{e} in (Kind.A, Kind.B)|callable({F})|Box({i}, 2) == Box({i}, 2)|Box({i}, 1) < Box({i}, 2)|bool({l})
{i} in Deck(*{l})|isinstance(Crate({i}), Box)|hasattr(Box(1, 1), {s})|{s}.isalpha()|math.isclose({f}, {f})|bool(np.any({a} > 1))
{d} == {d}|{i} in {z}|isinstance({i}, (str, int))|bool({s} and {i})|{i} is None|issubclass(Crate, Box)|{s}.isdigit()|bool({z})
{t} == tuple({l})|np.allclose({a}, {a})|Point({i}, 1) == ({i}, 1)|Has.WALL in (Has.WALL | Has.DOOR)|bool(Has.DOOR & Has(1))""",
    "l": """
{l} + {l}|[{i}, {i}]|[{i}, *{l}]|{l}[::-1]|{l}[1:]|{l}[:2]|{l}[-3:-1]|{l}[::2]|sorted({l})|sorted({l}, reverse=True)|{l} * 2
[x + 1 for x in {l}]|[x for x in {g} if x % 2]|[x * y for x in {l} for y in (1, 2)]|list({g})|list(map({F}, {l}))|list({t})
list(filter(None, {l}))|[*{g}, {i}]|sorted({z})|list({d}.values())|[len(w) for w in {s}.split()]|list(range({i} % 6))
list(accumulate({l}))|[a + b for a, b in zip({l}, {l})]|[i * x for i, x in enumerate({l}, 1)]|list(dict.fromkeys({l}))
[y := {i}, y + 1]|list(chain({l}, {t}))|[int(x) for x in {a}]|list(reversed({l}))|(lambda *a: list(a))(*{l})|list(Deck(*{l}))
[f(2) for f in [{F}, {F}]]|[f() for f in [lambda: x for x in range(3)]]|list(islice(naturals(), {i} % 4))|flat([{l}, [{l}]])
[(yes if x > 1 else no) for x, yes, no in [({i}, 1, 2)]]|[x for x, _ in groupby({l})]|list(takewhile(lambda x: x < 4, {l}))
[sum(p) for p in product({l}[:2], repeat=2)]|[a * 10 + b for a, b in combinations({l}[:4], 2)]|[k.value for k in Kind]
list(starmap(pow, [({i} % 5, 2)]))|[x for x, y in zip_longest({l}, {t}, fillvalue=0)]|nested({i} % 3)|[m.value for m in Level]
[b.m(1) for b in boxes({i} % 4)]|sorted((Box(x, 1) for x in {l}), key=lambda b: -b.w)[:1] and [1]|[d['k'] for d in [{{'k': {i}}}]]""",
    "t": """
({i}, {i})|tuple({l})|(*{t}, *{t})|{t}[::-1]|{t}[1:]|(*{t}, {i})|Point({i}, {i})|tuple(x * 2 for x in {t})|tuple(sorted({t}))
divmod({i}, 4)|tuple({g})|min_max({l} + [{i}])|Point(1, {i}) + Point({i}, 2)|tuple(map({F}, {t}))|({i},) * 2|astuple(Size({i}))[:2]""",
    "d": """
{d} | {d}|{{**{d}, 'k': {i}}}|{{s: i for i, s in enumerate(WORDS)}}|{{k: v + 1 for k, v in {d}.items()}}|dict(zip(WORDS, {l}))
dict(sorted({d}.items()))|{{v: k for k, v in zip({l}, 'abc')}} and {d}|{{str(x): x for x in {l}}}|dict(Counter({s}))|{{'w': vars(Box({i}, {i}))['w']}}
group({l})|{{'w': asdict(Size({i}))['width']}}|dict(a={i}, **{{'b': 2}})|{{k: v for k, v in {d}.items() if v}}|Point({i}, {i})._asdict()""",
    "z": "{z} | {z}|{z} & {z}|{z} - {z}|{z} ^ {z}|set({l})|{{x % 4 for x in {l}}}|set({t})|{{{i}, {i}}}|set({d}.values())",
    "a": """
{a} + {a}|{a} * {f}|{a} - {i}|{a} / 2|-{a}|np.abs({a})|{a}[::-1]|np.sort({a})|np.cumsum({a})|np.where({a} > 0, {a}, {f})
np.maximum({a}, {a})|np.clip({a}, -1, 1)|np.roll({a}, {i})|{a} @ np.eye(3)|np.cross({a}, [0, 0, 1])|np.round({a}, 2)|{a} ** 2
np.outer({a}, {a})[1]|({a}[:, None] + {a})[0]|np.sum([{a}, {a}], axis=0)|np.stack([{a}, {a}]).mean(axis=0)|scaled({a})|{a}.copy()
np.array([{f}, {f}, {i}])|np.concatenate([{a}[:1], {a}[1:]])|np.diff(np.append({a}, {f}))|np.einsum('i,i->i', {a}, {a})""",
    "g": """
count_to({i} % 5)|(x + 1 for x in {g})|(x for x in {l} if x > 0)|map({F}, {l})|filter(lambda v: v % 2, {l})|islice(naturals({i}), 3)
both({l}, {t})|chain({l}, {g})|Deck(*{l})|zip_sum({l}, {l})|reversed({l})|sorted({z})|walk([{l}, [{i}, {l}]])|enumerate_sum({l})""",
    "F": """
make_adder({i})|(lambda q: q * {i})|(lambda q, k={i}: q - k)|partial(mixed, {i})|compose({F}, {F})|Scaler({i})|Box({i}, {i}).m
({F} if {b} else {F})|memo(lambda q: q + {i})""",
    "e": "{e}|(Kind.A if {b} else Kind.C)|max(Kind, key=lambda k: k.value)|Kind({i} % 3 + 1)|next(iter(Kind))",
    "R": """
random.randint(0, 6)|random.random()|random.choice({l} + [1])|random.uniform(-1, 2)|np.random.rand()|np.random.randint(5)
random.gauss(0, 1)|float(np.random.normal())|sum(random.sample([1, 2, 3, 4], 2))|random.choice(WORDS)|rng.integers(9)
float(gen.random())|own.randint(1, 9)|random.randrange(1, 9, 2)|np.random.choice([2, 4])|sum(random.choices([1, 5], k=3))""",
}
_STATEMENTS = r"""
show({i})|show({f})|show({s})|show({l})|show({t}, {b})|show({d})|show({a})|show({e}.value, {s})|show(*{l})|show(sorted({z}))
if {b}:\n    {S}|if {b}:\n    {S}\nelse:\n    {S}|if {b}:\n    {S}\nelif {b}:\n    {S}\nelse:\n    {S}
for v in {l}:\n    {S}|for k, v in {d}.items():\n    show(k, v)\n    {S}|for v in {g}:\n    if {b}:\n        {X}\n    {S}
for j in range({i} % 4):\n    {S}\nelse:\n    {S}|{W} = 0\nwhile {W} < 3:\n    {W} += 1\n    {S}|for p, q in zip({l}, {t}):\n    show(p - q)
try:\n    {S}\n    show({i} // {i})\nexcept ZeroDivisionError as e:\n    show(str(e))\n    {S}
try:\n    show({l}[{i}])\nexcept (IndexError, KeyError):\n    {S}\nelse:\n    {S}\nfinally:\n    {S}
try:\n    raise Wrong({s}, {i})\nexcept Wrong as e:\n    show(e.n, str(e))|try:\n    checked({i})\n    {S}\nexcept ValueError as e:\n    show(str(e))
try:\n    try:\n        show({d}[{s}])\n    finally:\n        {S}\nexcept LookupError as e:\n    show(type(e).__name__)
with Guard({i}) as k:\n    show(k)\n    {S}|with scope({s}) as k:\n    {S}|with Guard({i}):\n    raise KeyError({s})
match {l}:\n    case []:\n        {S}\n    case [x]:\n        show(x)\n    case [x, *rest] if x > 1:\n        show(x, len(rest))\n    case _:\n        {S}
match {i}:\n    case 0 | 1:\n        {S}\n    case int(n) if n < 0:\n        show(-n)\n    case n:\n        show(n)
match {d}:\n    case {{'a': x, **rest}}:\n        show(x, len(rest))\n    case _:\n        {S}
match {e}:\n    case Kind.A:\n        {S}\n    case Kind.B | Kind.C:\n        {S}
match Box({i}, {i}):\n    case Box(w=0):\n        {S}\n    case Box(w, h) if w < h:\n        show(w, h)\n    case _:\n        {S}
n = {i}\nshow(n)\n{S}\nshow(n)|xs = {l}\nys = xs\nys.append({i})\nshow(xs)\n{S}\nshow(xs)|x = {f}\nx += {f}\nx *= 2\nshow(x)
xs = {l}\nxs[:2] = {l}\nxs += [{i}]\ndel xs[0]\nshow(xs)|xs = {l} + [1]\nxs[{i} % len(xs)] = {i}\nxs.sort(key={F})\nshow(xs)
d = {d}\nd[{s}] = {i}\nd.setdefault('q', {i})\nshow(d, len(d))|d = {d}\nd.update({d})\nshow(d.pop('a', {i}), list(d))
a, *rest = {l} + [{i}]\nshow(a, rest)|(a, b), c = ({i}, {s}), {f}\na, c = c, a\nshow(a, b, c)
def local(k, *more, sign=1):\n    return sign * (k + {i}) + len(more)\nshow(local({i}), local({i}, 2, sign=-1))
def step():\n    nonlocal total\n    total += {i}\n    return total\nshow(step(), step())
fs = [lambda: {i} + j for j in range(2)]\nshow([f() for f in fs])|fs = []\nfor j in range(3):\n    fs.append(lambda k, j=j: j * k)\nshow(fs[1]({i}))
m = np.zeros((2, 3))\nm[0] = {a}\nm[:, 1] += {f}\nview = m[1]\nview[:] = {a}\nm[m > 1] *= 2\nshow(m, m.T[0], m.sum(axis=0))
v = {a}\nv = v.astype(float)\nv[1:] *= 2\nw = v\nw += 1\nshow(v, np.argwhere(v > 1))|b = Box({i}, {i})\nb.h = {i}\nb.w += 1\nshow(b.area, b.m({i}), str(b))
c = Crate({i}, lid={i})\nc.total = {i}\nshow(c.total, c.m(2), c.log)|q = deque({l}, maxlen=3)\nq.appendleft({i})\nq.rotate(1)\nshow(list(q))
k = defaultdict(list)\nfor v in {l}:\n    k[v % 2].append(v)\nshow(sorted(k.items()))|h = list({l})\nheapq.heapify(h)\nheapq.heappush(h, {i})\nshow(heapq.heappop(h), h)
assert {i} > -10**9, 'small'\n{S}|global TOTAL\nTOTAL += {i}\nshow(TOTAL)|if (y := {i}) > 2:\n    show(y)|draws.append({R})\nshow(draws[-1])
draws.append({R})|xs = {l}\nrandom.shuffle(xs)\nshow(xs)|if random.random() < 0.5:\n    {S}|s = Size({i})\nt = replace(s, depth={i})\nshow(t > s, t, s == Size(2))
gen2 = count_to({i} % 5)\nshow(next(gen2, -1), list(gen2))|it = iter({l})\nfor v in it:\n    show(v, next(it, 'end'))
lines = [f'{{k:<4}}{{v:>3}}' for k, v in {d}.items()]\nshow(*lines)|z = {z}\nz = set(z)\nz.add({i})\nz.discard(1)\nshow(sorted(z))
del_me = [{i}, {i}]\ndel del_me[0], del_me[-1:]\nshow(del_me)|t = {t}\nt += ({i},)\nshow(t, t[-1], t[:1])|print({s}, {i}, sep='|')
"""
_FRAME = """from helper import *
from __future__ import annotations
import colorsys, heapq, math, random, re, statistics, textwrap
import numpy as np
from abc import ABC, abstractmethod
from bisect import bisect as find_place
from collections import Counter, defaultdict, deque
from contextlib import contextmanager
from dataclasses import asdict, astuple, dataclass, field, replace
from enum import Enum, Flag, IntEnum, auto
from fractions import Fraction
from functools import lru_cache, partial, reduce, wraps
from itertools import accumulate, chain, combinations, groupby, islice, product, starmap, takewhile, zip_longest
from typing import NamedTuple

N = %d
WORDS = ['oak', 'fir', 'a b']
NUMBERS = (4, 1, 7)
TABLE = {'one': 1, 'two': 2}
TOTAL = 0
out = []
draws = []
own = random.Random(N)
gen = np.random.default_rng(N)
rng = np.random.default_rng(3)

class Kind(Enum):
    A = 1
    B = auto()
    C = 3

class Level(IntEnum):
    LOW = 1
    HIGH = 2

class Has(Flag):
    WALL = auto()
    DOOR = auto()

class Wrong(Exception):
    def __init__(self, text, n):
        super().__init__(f'{text}!')
        self.n = n

class Point(NamedTuple):
    x: int
    y: int = 3
    def norm1(self): return abs(self.x) + abs(self.y)
    def __add__(self, o): return Point(self.x + o.x, self.y + o.y)

class Base(ABC):
    count = 2
    def __init__(self): self.log = []
    @abstractmethod
    def m(self, k): ...
    @classmethod
    def unit(cls, n): return cls(n, 1)

class Box(Base):
    __match_args__ = ('w', 'h')
    def __init__(self, w, h):
        super().__init__()
        self.w, self.h = w, h
    @property
    def area(self): return self.w * self.h
    @property
    def ratio(self): return self.w / (abs(self.h) + 1)
    def m(self, k): return self.w + k * %d
    def __add__(self, o): return Box(self.w + o.w, self.h + o.h)
    def __matmul__(self, o): return self.w * o.w + self.h * o.h
    def __eq__(self, o): return isinstance(o, Box) and (self.w, self.h) == (o.w, o.h)
    def __lt__(self, o): return self.area < o.area
    def __hash__(self): return hash((self.w, self.h))
    def __repr__(self): return f'{type(self).__name__}({self.w!r}, {self.h})'
    def __str__(self): return f'<{self.w}x{self.h}>'

class Crate(Box):
    def __init__(self, w, h=2, *, lid=0):
        super().__init__(w, h)
        self.__lid = lid
    @property
    def total(self): return self.area + self.__lid
    @total.setter
    def total(self, value):
        self.log.append(value)
        self.__lid = value
    def m(self, k): return super().m(k) - 1

@dataclass(order=True)
class Size:
    width: int
    depth: int = 2
    tags: list = field(default_factory=list, compare=False)

class Deck:
    def __init__(self, *items): self.items = list(items)
    def __len__(self): return len(self.items)
    def __getitem__(self, i): return self.items[i]
    def __iter__(self): yield from self.items

class Scaler:
    def __init__(self, k): self.k = k
    def __call__(self, x): return self.k * x

class Guard:
    def __init__(self, n): self.n = n
    def __enter__(self):
        out.append(self.n)
        return self.n + 1
    def __exit__(self, kind, value, trace):
        out.append(0 if kind is None else len(kind.__name__))
        return kind is KeyError

@contextmanager
def scope(name):
    out.append(len(name))
    try:
        yield name * 2
    finally:
        out.append(-1)

def shout(f):
    @wraps(f)
    def inner(*a, **k):
        return f(*a, **k) + 1
    return inner

@shout
def twice(x): return x * 2
def mixed(a, b, c=1): return a * 10 + b - c
def memo(f): return lru_cache(maxsize=None)(f)
def compose(f, g): return lambda x: f(g(x))
def make_adder(n):
    def add(x): return x + n
    return add
def first(items, default): return next(iter(items), default)
def tally(*a, k=0, **rest): return sum(a) + k * 2 + len(rest)
def lerp(a, b, t): return a + (b - a) * t
def min_max(v): return min(v), max(v)
def boxes(n): return [Box(i, i + 1) for i in range(n)]
def scaled(v):
    v = np.array(v, dtype=float)
    v[0] += 1
    return v / (np.abs(v).max() + 1)
def pairwise_diff(v): return [b - a for a, b in zip(v, v[1:])]
def flat(v): return [x for e in v for x in (flat(e) if isinstance(e, list) else [e])]
def nested(n): return [n, *(nested(n - 1) if n > 0 else [])]
def group(v):
    found = {}
    for x in v: found.setdefault(str(x %% 2), []).append(x)
    return {k: len(g) for k, g in found.items()}
@lru_cache
def fib(n): return n if n < 2 else fib(n - 1) + fib(n - 2)
def counter(state=[0]):
    state[0] += 1
    return state[0]
def safe(a, b):
    try:
        return a // b
    except ZeroDivisionError:
        return -1
    finally:
        out.append(9)
def checked(n):
    if n < 0: raise ValueError(f'bad {n}')
    if n > 20:
        try:
            {}[n]
        except KeyError as e:
            raise Wrong('big', n) from e
    return n
def attempt(f):
    try:
        return str(f())
    except Exception as e:
        return f'{type(e).__name__}: {e}'
def count_to(n):
    i = 0
    while i < n:
        i += 1
        yield i
def naturals(start=0):
    while True:
        yield start
        start += 1
def both(p, q):
    yield from p
    yield len(p)
    yield from reversed(q)
def zip_sum(p, q):
    for x, y in zip(p, q): yield x + y
def enumerate_sum(v): return (i + x for i, x in enumerate(v))
def walk(v):
    for x in v:
        if isinstance(x, list): yield from walk(x)
        else: yield x
def describe(v):
    match v:
        case bool(): return 1
        case int() if v > 5: return 2
        case int(): return 3
        case [x, y]: return 4
        case [x, *_]: return 5
        case {'a': int(n)}: return n
        case Kind.A: return 6
        case Box(w, h): return w - h
        case _: return 7
def kind_of(v): return type(v).__name__

def marks(value):
    if isinstance(value, (list, tuple)):
        return [len(value) + 0.5] + [m for each in value for m in marks(each)]
    if isinstance(value, np.ndarray):
        return marks(value.tolist())
    if isinstance(value, (bool, int, float, np.number, np.bool_)):
        return [float(value)]
    text = value if isinstance(value, str) else repr(value)
    return [sum((i %% 7 + 1) * ord(c) for i, c in enumerate(text)) / 8]

def show(*values):
    for value in values:
        out.extend(marks(value))

def values():
    total = 0
%s

@register()
def scene() -> Shape:
    values()
    return concat_shapes(*[
        transform_shape(primitive_call('cube'), translation_matrix((k, x, 0))) for k, x in enumerate([0.5, *out][:400])
    ])
"""


def _alternatives(text: str) -> list[str]:
    """The templates of a rule; a bar inside a template's brackets or texts does not end it."""
    found, depth, start, quote = [], 0, 0, ""
    text = text.strip("\n").replace("\n", "|")
    for i, c in enumerate(text):
        if quote:
            quote = "" if c == quote else quote
        elif c in "'\"":
            quote = c
        elif c in "([{":
            depth += 1
        elif c in ")]}":
            depth -= 1
        elif c == "|" and not depth and not (text[i - 1] == " " and text[i + 1 : i + 2] == " "):
            found.append(text[start:i])
            start = i + 1
    return [each for each in [*found, text[start:]] if each]


RULES = {kind: _alternatives(text) for kind, text in _GRAMMAR.items()}
SIMPLE = {kind: _alternatives(text) for kind, text in _SIMPLE.items()}
LEAVES = {kind: _alternatives(text) for kind, text in _LEAVES.items()}
STATEMENTS = [each for line in _STATEMENTS.strip().split("\n") for each in _alternatives(line)]


class ModernWriter(Writer):
    """Fills the templates; its choices are those of a seed."""

    def __init__(self, seed: int) -> None:
        super().__init__(lambda strategy: None)
        self._chance = random.Random(seed)
        self._room = 0
        self._in_loop = 0

    def pick(self, options: list[str]) -> str:
        return self._chance.choice(options)

    def whole(self, low: int, high: int) -> int:
        return self._chance.randint(low, high)

    def flip(self) -> bool:
        return self._chance.random() < 0.5

    def expression(self, kind: str, depth: int) -> str:
        """An expression of a type, in parentheses where it needs them."""
        self._room -= 1
        names = LEAVES.get(kind)
        if names is not None and (depth <= 0 or self._room < 0):
            return self._grouped(self.pick(names))
        text = self.pick(RULES[kind])
        text = text.replace("{digits}", str(self.whole(1, 999)))
        text = text.replace("{g!r}", "iter({l})").replace("bisect({l!s}", "find_place(sorted({l})")
        text = self._with_simple_texts(text)
        filled = _HOLE.sub(lambda hole: self.expression(hole[1], depth - 1), text)
        return self._grouped(filled.replace("{{", "{").replace("}}", "}"))

    def _with_simple_texts(self, text: str) -> str:
        """Fill the holes of formatted texts with expressions that have no quotes and braces, as Python 3.11 needs."""
        fill = lambda hole: self.pick(SIMPLE[hole[1]])
        return re.sub(r"f'[^']*'", lambda found: _HOLE.sub(fill, found[0]), text)

    @staticmethod
    def _grouped(text: str) -> str:
        return text if re.fullmatch(r"[\w.]+|'[^']*'|\w+\([^()]*\)|\[[^\[\]]*\]", text) else f"({text})"

    def statement(self, depth: int) -> list[str]:  # type: ignore[override]
        """The lines of a statement."""
        found: list[str] = []
        template = self.pick([s for s in STATEMENTS if "{S}" not in s] if depth <= 0 else STATEMENTS)
        if "global" in template and depth < 3:
            return ["pass"]
        self.counter += 1
        for line in template.replace("{W}", f"w{self.counter}").split("\\n"):
            bare = line.lstrip()
            indent = line[: len(line) - len(bare)]
            if bare == "{S}":
                for _ in range(self.whole(1, 2)):
                    found += [indent + each for each in self.statement(depth - 1)]
            elif bare == "{X}":
                found.append(indent + self.pick(["continue", "break", "pass"]))
            else:
                self._room = 14
                filled = _HOLE.sub(lambda hole: self.expression(hole[1], 2), self._with_simple_texts(line))
                found.append(filled.replace("{{", "{").replace("}}", "}"))
        return found


def modern_program(seed: int) -> str:
    """The text of a program."""
    writer = ModernWriter(seed)
    body = [line for _ in range(writer.whole(3, 9)) for line in writer.statement(3)]
    lines = "\n".join(f"    {line}" for line in body if line != "global TOTAL")
    if "TOTAL" in lines:
        lines = "    global TOTAL\n" + lines
    frame = _FRAME.replace("from helper import *\nfrom __future__", "from __future__").replace(
        "annotations\n", "annotations\nfrom helper import *\n", 1
    )
    return frame % (writer.whole(1, 6), writer.whole(-2, 3), lines)
