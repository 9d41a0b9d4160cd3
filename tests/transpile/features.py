"""Features of current Python, one small program each: what stands before an empty line is at the top level."""

from __future__ import annotations

FRAME = """from helper import *
import math, random
import numpy as np
{top}

def values():
{body}

def marks(value):
    if isinstance(value, (list, tuple, np.ndarray)):
        return [len(value) + 0.5] + [m for each in value for m in marks(each)]
    if isinstance(value, (bool, int, float, np.number, np.bool_)):
        return [float(value)]
    text = value if isinstance(value, str) else repr(value)
    return [sum((i % 7 + 1) * ord(c) for i, c in enumerate(text)) / 8]

@register()
def scene() -> Shape:
    found = marks(values())
    return concat_shapes(*[
        transform_shape(primitive_call('cube'), translation_matrix((k, x, 0))) for k, x in enumerate(found)
    ])
"""
TEXT = r'''
## enum
from enum import Enum
class Color(Enum):
    RED = 1
    GREEN = 2
    BLUE = 2
    @property
    def twice(self): return self.value * 2
    def describe(self): return f'{self.name}={self.value}'

return Color.RED.value, Color['GREEN'].name, Color(2).twice, Color.BLUE is Color.GREEN, len(Color), [c.name for c in Color], repr(Color.RED), str(Color.BLUE), Color.RED.describe(), Color.RED in Color, list(Color.__members__), f'{Color.RED}', {Color.RED: 3}[Color.RED]
## enum auto
from enum import Enum, auto
class Kind(Enum):
    A = auto()
    B = auto()
    C = 10
    D = auto()

return [k.value for k in Kind], Kind.D.name, Kind.A == Kind.A, Kind.A != Kind.B, Kind.A == 1, isinstance(Kind.A, Kind)
## int enum
from enum import IntEnum
class Level(IntEnum):
    LOW = 1
    HIGH = 3

return Level.HIGH + 1, Level.LOW < Level.HIGH, max(Level).name, sorted(Level, reverse=True)[0].value, [10, 20, 30, 40][Level.HIGH], f'{Level.LOW}', str(Level.LOW), repr(Level.LOW), Level(3).name, range(5)[Level.LOW], Level.HIGH == 3
## str enum
from enum import StrEnum, auto, Enum
class Side(StrEnum):
    LEFT = auto()
    RIGHT = 'r'
class Old(str, Enum):
    A = 'a'

return Side.LEFT, Side.RIGHT.upper(), f'{Side.LEFT}!', Side('r').name, Side.LEFT == 'left', {'left': 5}[Side.LEFT], Old.A == 'a', Old.A.value, str(Old.A), f'{Old.A}'
## flag
from enum import Flag, IntFlag, auto
class Has(Flag):
    NONE = 0
    WALL = auto()
    ROOF = auto()
    DOOR = auto()
    HOUSE = WALL | ROOF
class Perm(IntFlag):
    R = 4
    W = 2

x = Has.WALL | Has.DOOR
return x.value, Has.WALL in x, Has.ROOF in x, bool(Has.NONE), (x & Has.WALL).name, (x ^ Has.WALL) == Has.DOOR, (~Has.WALL).value, Has.HOUSE.value, len(Has), [f.name for f in x], bool(x & Has.ROOF), Perm.R | Perm.W, (Perm.R | Perm.W).value, Perm.R + 1, repr(Has.WALL), repr(x), str(x), str(Has.NONE)
## enum with init
from enum import Enum
class Planet(Enum):
    EARTH = (5.9, 6.3)
    MARS = (0.6, 3.4)
    def __init__(self, mass, radius):
        self.mass = mass
        self.radius = radius
    @property
    def density(self): return self.mass / self.radius ** 3
    @classmethod
    def heaviest(cls): return max(cls, key=lambda p: p.mass)
    @staticmethod
    def unit(): return 'kg'

return Planet.EARTH.mass, Planet.MARS.density, Planet.heaviest().name, Planet.unit(), Planet.MARS.value, Planet((0.6, 3.4)).name
## enum with data
from enum import Enum, unique
@unique
class Tree(Enum):
    OAK = {'h': 5}
    PINE = {'h': 9}
    def __str__(self): return self.name.title()
    def __lt__(self, other): return self.value['h'] < other.value['h']

return Tree.OAK.value['h'], str(Tree.PINE), f'{Tree.OAK}', [t.name for t in sorted(Tree)], next(iter(Tree)).name, Tree.PINE.name in Tree.__members__
## enum mistakes
from enum import Enum
class C(Enum):
    A = 1
def attempt(f):
    try:
        return f()
    except Exception as e:
        return type(e).__name__, str(e)

return attempt(lambda: C(5)), attempt(lambda: C['X']), attempt(lambda: C.X)[0], attempt(lambda: setattr(C.A, 'value', 3))[0]
## inheritance
class Shape0:
    sides = 0
    def __init__(self, name): self.name = name
    def area(self): return 0
    def describe(self): return f'{self.name}:{self.area()}:{self.sides}'
class Rect(Shape0):
    sides = 4
    def __init__(self, w, h):
        super().__init__('rect')
        self.w, self.h = w, h
    def area(self): return self.w * self.h
class Square(Rect):
    def __init__(self, s): super().__init__(s, s)
    def describe(self): return 'sq-' + super().describe()

s = Square(3)
return s.describe(), Rect(2, 5).area(), isinstance(s, Rect), isinstance(s, Shape0), issubclass(Square, Shape0), type(s).__name__, s.__class__.__name__, type(s) is Square, Square.__name__, hasattr(s, 'w'), getattr(s, 'zzz', 7), Square.sides
## multiple inheritance
class A:
    def who(self): return ['A']
class B(A):
    def who(self): return ['B'] + super().who()
class C(A):
    def who(self): return ['C'] + super().who()
class D(B, C):
    def who(self): return ['D'] + super().who()

return D().who(), isinstance(D(), C), super(D, D()).who()
## mixins
class Named:
    def __init__(self, name='n', **kw):
        super().__init__(**kw)
        self.name = name
class Sized0:
    def __init__(self, size=1, **kw):
        super().__init__(**kw)
        self.size = size
class Both(Named, Sized0):
    def __init__(self, **kw): super().__init__(**kw)

b = Both(name='q', size=4)
return b.name, b.size, Both().size, [c.__name__ for c in Both.__mro__][:3]
## abstract classes
from abc import ABC, abstractmethod
class Part(ABC):
    @abstractmethod
    def size(self): ...
    @property
    @abstractmethod
    def color(self): ...
    def both(self): return self.size(), self.color
class Leg(Part):
    def size(self): return 3
    @property
    def color(self): return 'red'

try:
    Part()
except TypeError as e:
    text = str(e)[:37]
return Leg().both(), text, isinstance(Leg(), Part)
## protocols
from typing import Protocol, runtime_checkable
@runtime_checkable
class Drawable(Protocol):
    def draw(self, x: int) -> int: ...
class Cat:
    def draw(self, x): return x * 2
class Dog:
    pass

def use(d: Drawable) -> int: return d.draw(4)
return use(Cat()), isinstance(Cat(), Drawable), isinstance(Dog(), Drawable)
## typed dict
from typing import TypedDict, NotRequired
class Spec(TypedDict, total=False):
    size: float
    name: str
    extra: NotRequired[int]

s: Spec = {'size': 2.5, 'name': 'a'}
t = Spec(size=1, name='b')
return s['size'], t, t.get('extra', 9), type(t).__name__
## class attributes
class Counter0:
    total = 0
    names = []
    def __init__(self, name):
        Counter0.total += 1
        self.names.append(name)
        self.number = Counter0.total
class Sub(Counter0):
    total = 100

a, b, c = Counter0('a'), Counter0('b'), Sub('c')
a.total = 50
return Counter0.total, a.total, b.total, Sub.total, c.names, c.number, a.__dict__, vars(b), 'total' in vars(a)
## properties
class Box:
    def __init__(self): self._w = 1
    @property
    def w(self): return self._w
    @w.setter
    def w(self, value):
        if value < 0: raise ValueError('negative')
        self._w = value
    @w.deleter
    def w(self): self._w = 0
    @property
    def only(self): return 5
    area = property(lambda self: self._w ** 2)

b = Box()
b.w = 4
b.w += 2
found = [b.w, b.area]
for f in (lambda: setattr(b, 'w', -1), lambda: setattr(b, 'only', 1)):
    try: f()
    except (ValueError, AttributeError) as e: found.append(str(e))
del b.w
return found, b.w
## classmethod and staticmethod
class P:
    unit = 2
    def __init__(self, x): self.x = x
    @classmethod
    def of(cls, x): return cls(x * cls.unit)
    @staticmethod
    def add(a, b): return a + b
class Q(P):
    unit = 3

return P.of(2).x, Q.of(2).x, type(Q.of(1)).__name__, P.add(1, 2), Q(1).add(3, 4), Q(0).of(5).x
## arithmetic dunders
class V:
    def __init__(self, x, y): self.x, self.y = x, y
    def __add__(self, o): return V(self.x + o.x, self.y + o.y) if isinstance(o, V) else NotImplemented
    def __radd__(self, o): return self if o == 0 else NotImplemented
    def __sub__(self, o): return V(self.x - o.x, self.y - o.y)
    def __mul__(self, k): return V(self.x * k, self.y * k) if not isinstance(k, V) else self.x * k.x + self.y * k.y
    __rmul__ = __mul__
    def __truediv__(self, k): return V(self.x / k, self.y / k)
    def __floordiv__(self, k): return V(self.x // k, self.y // k)
    def __mod__(self, k): return V(self.x % k, self.y % k)
    def __pow__(self, k): return V(self.x ** k, self.y ** k)
    def __matmul__(self, o): return self * o
    def __neg__(self): return V(-self.x, -self.y)
    def __pos__(self): return self
    def __abs__(self): return math.hypot(self.x, self.y)
    def __invert__(self): return V(self.y, self.x)
    def __iadd__(self, o):
        self.x += o.x
        return self
    def __eq__(self, o): return (self.x, self.y) == (o.x, o.y)
    def __repr__(self): return f'V({self.x}, {self.y})'
    def __round__(self, n=0): return V(round(self.x, n), round(self.y, n))

a, b = V(3, 4), V(1, 2)
c = a
c += b
try: a + 1
except TypeError as e: text = str(e)
return a + b, a - b, a * 2, 2 * a, a * b, a / 2, a // 2, a % 2, b ** 2, a @ b, -a, +a, abs(V(3, 4)), ~a, sum([a, b, b]), a is c, a == V(4, 4), a != b, round(V(1.25, 2.55), 1), text
## container dunders
class Deck:
    def __init__(self, *items): self.items = list(items)
    def __len__(self): return len(self.items)
    def __getitem__(self, i): return Deck(*self.items[i]) if isinstance(i, slice) else self.items[i]
    def __setitem__(self, i, v): self.items[i] = v
    def __delitem__(self, i): del self.items[i]
    def __contains__(self, v): return v in self.items
    def __iter__(self): return iter(self.items)
    def __reversed__(self): return reversed(self.items)
    def __bool__(self): return len(self.items) > 1

d = Deck(5, 6, 7, 8)
d[1] = 60
d[0] += 1
del d[-1]
first, *rest = d
return len(d), d[1], list(d), list(reversed(d)), 60 in d, 61 not in d, bool(Deck(1)), [*d[1:]], first, rest, max(d), sorted(d), dict(enumerate(d)), list(zip(d, d)), sum(d), tuple(map(str, d))
## iteration by getitem
class Squares:
    def __getitem__(self, i):
        if i >= 4: raise IndexError(i)
        return i * i

return list(Squares()), 9 in Squares(), 5 in Squares(), sum(Squares()), [x for x in Squares()]
## iterator class
class Down:
    def __init__(self, n): self.n = n
    def __iter__(self): return self
    def __next__(self):
        if self.n <= 0: raise StopIteration
        self.n -= 1
        return self.n

it = Down(4)
return next(it), list(it), next(it, 'end'), [x + y for x, y in zip(Down(3), Down(5))]
## callable objects
class Scale:
    def __init__(self, k): self.k = k
    def __call__(self, x, *, plus=0): return self.k * x + plus

s = Scale(3)
return s(2), list(map(s, [1, 2])), s(1, plus=4), callable(s), callable(3), sorted([3, 1, 2], key=Scale(-1))
## comparison dunders
from functools import total_ordering
@total_ordering
class Age:
    def __init__(self, n): self.n = n
    def __eq__(self, o): return self.n == o.n
    def __lt__(self, o): return self.n < o.n
    def __hash__(self): return hash(self.n)
    def __repr__(self): return f'A{self.n}'

a, b = Age(1), Age(2)
return a < b, a <= b, a > b, a >= b, a == Age(1), a != b, max(a, b), sorted([b, a]), len({a, Age(1), b}), {a: 5}[Age(1)], min([b, a], key=lambda x: -x.n)
## texts of objects
class T:
    def __init__(self, v): self.v = v
    def __repr__(self): return f'T<{self.v!r}>'
    def __str__(self): return f'<{self.v}>'
    def __format__(self, spec): return f'[{self.v:{spec or ">4"}}]'

t = T(3)
return str(t), repr(t), f'{t}', f'{t:05.1f}', f'{t!s:>6}', f'{t!r}', '{:^5}'.format(t), [t], {'a': t}, 'x%s' % t, format(t, '<3')
## attribute hooks
class Bag:
    def __init__(self): self.known = 1
    def __getattr__(self, name):
        if name.startswith('get_'): return lambda: name[4:]
        raise AttributeError(name)
    def __setattr__(self, name, value): object.__setattr__(self, name, value * 2)

b = Bag()
b.z = 5
return b.known, b.get_size(), hasattr(b, 'other'), getattr(b, 'other', 'none'), b.z
## slots, new and class call
class One:
    __slots__ = ('x',)
    made = None
    def __new__(cls):
        if cls.made is None: cls.made = super().__new__(cls)
        return cls.made
class Celsius(float):
    @property
    def f(self): return self * 9 / 5 + 32
    def __add__(self, o): return Celsius(float(self) + o)

a, b = One(), One()
a.x = 4
return a is b, b.x, Celsius(100).f, (Celsius(1.5) + 2).f, Celsius(2) * 2, isinstance(Celsius(1), float)
## context managers
class Shift:
    log = []
    def __init__(self, d): self.d = d
    def __enter__(self):
        self.log.append(('in', self.d))
        return self.d * 2
    def __exit__(self, kind, value, trace):
        self.log.append(('out', self.d, None if kind is None else kind.__name__, str(value)))
        return kind is KeyError

with Shift(1) as a, Shift(2) as b:
    c = a + b
with Shift(3):
    raise KeyError('k')
try:
    with (Shift(4) as d, Shift(5)):
        raise ValueError('v')
except ValueError:
    pass
for i in range(2):
    with Shift(6 + i):
        if i == 0: continue
        break
return c, d, Shift.log
## contextlib
from contextlib import contextmanager, suppress, ExitStack, nullcontext
log = []
@contextmanager
def level(n):
    log.append(n)
    try:
        yield n * 10
    except ZeroDivisionError as e:
        log.append('caught')
    finally:
        log.append(-n)

with level(1) as a:
    with level(2) as b:
        log.append(a + b)
with level(3): 1 / 0
with suppress(KeyError, IndexError):
    [][1]
    log.append('never')
with ExitStack() as stack:
    c = [stack.enter_context(level(i)) for i in (4, 5)]
    stack.callback(log.append, 'bye')
with nullcontext(7) as n: log.append(n)
return log, c
## dataclass
from dataclasses import dataclass, field
@dataclass
class P:
    x: float
    y: float = 2.0
    tags: list = field(default_factory=list)
    hidden: int = field(default=5, repr=False, compare=False)
    area: float = field(init=False)
    def __post_init__(self): self.area = self.x * self.y
    def moved(self, dx=0): return P(self.x + dx, self.y)

a, b = P(1), P(1, y=2.0)
a.tags.append('t')
return a, b, a == b, P(1) == b, b.moved(2).x, a.area, a.hidden, repr(P(3, 4, ['z'])), b != a
## dataclass inheritance
from dataclasses import dataclass, field
@dataclass
class Base0:
    name: str
    size: float = 1.0
    def volume(self): return self.size ** 3
@dataclass
class Tree(Base0):
    height: float = 3.0
    size: float = 2.0
    kids: list['Tree'] = field(default_factory=list)
    def total(self): return self.volume() + sum(k.total() for k in self.kids)
@dataclass
class Pine(Tree):
    def volume(self): return super().volume() * 10

t = Tree('a', kids=[Tree('b', 3.0), Pine('c')])
return t, t.total(), Pine('p').volume(), isinstance(Pine('q'), Tree)
## dataclass options
from dataclasses import dataclass, replace, asdict, astuple, fields, FrozenInstanceError, is_dataclass, KW_ONLY
@dataclass(frozen=True, order=True)
class V:
    x: int
    y: int = 0
@dataclass(kw_only=True, slots=True)
class K:
    a: int
    b: int = 2
@dataclass
class M:
    v: V
    _: KW_ONLY
    n: int = 3

a = V(1, 5)
try: a.x = 3
except FrozenInstanceError as e: text = str(e)
try: K(1)
except TypeError as e: text2 = type(e).__name__
return a < V(2), sorted([V(2), V(1, 1), V(1)]), hash(a) == hash(V(1, 5)), {a: 3}[V(1, 5)], replace(a, y=7), asdict(M(a)), astuple(M(a, n=4)), [f.name for f in fields(M)], text, text2, is_dataclass(a), max(V(1), V(0, 9)), K(a=1), V(1) >= V(1)
## dataclass init variables
from dataclasses import dataclass, InitVar
from typing import ClassVar
@dataclass
class R:
    w: float
    count: ClassVar[int] = 0
    scale: InitVar[float] = 2.0
    def __post_init__(self, scale):
        self.w *= scale
        R.count += 1

a, b = R(1), R(2, scale=5)
return a, b.w, R.count
## dataclass methods
from dataclasses import dataclass
@dataclass(eq=False)
class N:
    v: int
@dataclass
class Poly:
    c: tuple
    def __call__(self, x): return sum(k * x ** i for i, k in enumerate(self.c))
    def __add__(self, o): return Poly(tuple(a + b for a, b in zip(self.c, o.c)))
    def __str__(self): return '+'.join(f'{k}x^{i}' for i, k in enumerate(self.c))
    @classmethod
    def zero(cls): return cls((0,))
    @property
    def degree(self): return len(self.c) - 1
    __match_args__ = ('c',)

n = N(1)
return n == n, n == N(1), Poly((1, 2))(3), Poly((1, 2)) + Poly((3, 4)), str(Poly((1, 5))), Poly.zero(), Poly((1, 2, 3)).degree, len({n, N(1)})
## named tuples
from typing import NamedTuple
from collections import namedtuple
class P(NamedTuple):
    x: float
    y: float = 5
    def norm(self): return math.hypot(*self)
    @property
    def sum(self): return self.x + self.y
    def __add__(self, o): return P(self.x + o.x, self.y + o.y)
Q = namedtuple('Q', 'a b c', defaults=[9])

p = P(1)
x, y = p
a, *r = Q(1, 2)
return p, p[1], p.x + y, len(p), list(p), p._replace(x=3), p._asdict(), P._fields, p == (1, 5), p.norm(), p.sum, p + P(1, 1), Q(1, b=2), r, P._make([7, 8]), sorted([P(2), P(1)]), p[::-1], max(p), (1, 5) in [p], isinstance(p, tuple), hash(p) == hash((1, 5)), p * 2, dict(zip(p._fields, p))
## generics
from typing import Generic, TypeVar, TypeAlias, Union, Optional
T = TypeVar('T')
Vec: TypeAlias = 'tuple[float, float]'
Number = Union[int, float]
class Stack(Generic[T]):
    def __init__(self, *items: T) -> None: self.items: list[T] = list(items)
    def push(self, item: T) -> 'Stack[T]':
        self.items.append(item)
        return self
    def pop(self) -> Optional[T]: return self.items.pop() if self.items else None
class Ints(Stack[int]):
    pass

s: Stack[int] = Stack[int](1, 2)
return s.push(5).pop(), Stack().pop(), Ints(3).items
## type parameters
class Pair[A, B]:
    def __init__(self, a: A, b: B): self.a, self.b = a, b
    def swapped(self) -> 'Pair[B, A]': return Pair(self.b, self.a)
def first[T](items: list[T]) -> T: return items[0]
type Point = tuple[float, float]

p: Point = (1, 2)
return Pair(1, 'x').swapped().a, first([4, 5]), p
## match values
def kind(v):
    match v:
        case 0: return 'zero'
        case 1 | 2 | 3: return 'small'
        case -1: return 'minus'
        case 2.5: return 'float'
        case 'a' | 'b': return 'letter'
        case None: return 'none'
        case True: return 'true'
        case str(): return 'str'
        case int(n) if n > 100: return f'big {n}'
        case int() | float() as n: return f'num {n}'
        case _: return 'other'

return [kind(v) for v in (0, 2, -1, 2.5, 'b', None, 'zz', 500, 50, 7.5, [], True, False)]
## match sequences
def m(v):
    match v:
        case []: return 'empty'
        case [x]: return ('one', x)
        case ['go', ('n' | 's') as d, *rest]: return (d, rest)
        case [first, *_, last] if first == last: return ('same', first)
        case (x, (y, z)): return x + y + z
        case [1, *rest]: return rest
        case [_, _, _]: return 'three'
        case _: return 'other'

return [m(v) for v in ([], [5], ['go', 'n', 1, 2], [3, 4, 3], (1, (2, 3)), [1, 8, 9, 10], (4, 5, 6), 'abc', {1: 2}, range(1))]
## match mappings
def m(v):
    match v:
        case {'type': 'cube', 'size': s}: return s
        case {'type': 'ball', **rest}: return sorted(rest.items())
        case {'pos': [x, y], 'n': int(n)}: return x + y + n
        case {}: return 'dict'
    return 'none'

return [m(v) for v in ({'type': 'cube', 'size': 3, 'z': 1}, {'type': 'ball', 'r': 2, 'c': 1}, {'pos': (1, 2), 'n': 3}, {'n': 'x'}, {}, 5)]
## match classes
from dataclasses import dataclass
from enum import Enum
@dataclass
class Circle:
    r: float
@dataclass
class Rect:
    w: float
    h: float
class Mode(Enum):
    FAST = 1
    SLOW = 2
class Plain:
    __match_args__ = ('a',)
    def __init__(self, a): self.a, self.b = a, a * 2
def area(s):
    match s:
        case Circle(r=0): return 'dot'
        case Circle(r): return 3 * r * r
        case Rect(w, h) if w == h: return ('square', w)
        case Rect(w=w, h=3): return w * 3
        case Rect(w): return w
        case Plain(a, b=8): return ('eight', a)
        case Plain(): return 'plain'
        case Mode.FAST: return 'fast'
        case Mode(): return 'mode'
        case [Circle(r), Rect(w, _)] if r < w: return r + w
        case float(x) | int(x): return x

return [area(s) for s in (Circle(0), Circle(2), Rect(2, 2), Rect(5, 3), Rect(7, 8), Plain(4), Plain(5), Mode.FAST, Mode.SLOW, [Circle(1), Rect(2, 3)], 2.5, 'no')]
## exceptions
class SceneError(Exception): pass
class SizeError(SceneError, ValueError):
    def __init__(self, size, note='n'):
        super().__init__(f'bad size {size}')
        self.size, self.note = size, note
def check(n):
    try:
        if n == 0: raise SizeError(n)
        if n == 1: return 1 / 0
        if n == 2: return {}['k']
        if n == 3: return [1][5]
        if n == 4: int('x')
        if n == 5: raise SceneError('a', 2)
        if n == 6: assert n < 6, 'too large'
        if n == 7: None.x
        if n == 8: 'a' + 1
        if n == 9: undefined
    except SizeError as e: return ('size', e.size, str(e), e.note, e.args)
    except (ZeroDivisionError, KeyError) as e: return (type(e).__name__, str(e), e.args)
    except LookupError as e: return 'lookup ' + str(e)
    except ValueError as e: return 'value ' + str(e)
    except SceneError as e: return (repr(e), str(e))
    except Exception as e: return (type(e).__name__, str(e))
    else: return 'else'
    finally: log.append(n)
    return 'after'
log = []

return [check(n) for n in range(11)], log
## raise from
class Wrong(Exception): pass
def f():
    try:
        int('q')
    except ValueError as e:
        raise Wrong('outer') from e

try: f()
except Wrong as e: a = (str(e), type(e.__cause__).__name__, str(e.__cause__))
try:
    try: raise KeyError('a')
    except KeyError: raise
except KeyError as e: b = e.args[0]
def g():
    try: return 'try'
    finally: log.append('fin')
def h():
    for i in range(3):
        try:
            if i == 1: continue
            if i == 2: break
        finally: log.append(i)
    else: log.append('else')
    return i
log = []
return a, b, g(), h(), log
## exception groups of handlers
def f(x):
    try:
        try:
            return 10 / x
        except TypeError:
            return 'type'
        finally:
            log.append('inner')
    except ZeroDivisionError:
        log.append('zero')
        return -1
    else:
        log.append('else')
log = []

try: raise StopIteration
except StopIteration: c = 1
try: raise ValueError
except Exception as e: d = (str(e), e.args, isinstance(e, ValueError))
return f(2), f(0), f('a'), log, c, d
## decorators
from functools import wraps
def twice(f):
    @wraps(f)
    def inner(*args, **kw):
        return f(*args, **kw) * 2
    return inner
def add(n):
    def deco(f):
        def inner(*a): return f(*a) + n
        return inner
    return deco
class Count:
    def __init__(self, f): self.f, self.n = f, 0
    def __call__(self, *a):
        self.n += 1
        return self.f(*a)
@twice
@add(5)
def f(x): return x
@Count
def g(x): return x + 1
@twice
def doc():
    """Doc of doc"""
    return 1

return f(1), g(1) + g(2), g.n, doc.__name__, doc.__doc__, doc.__wrapped__()
## registry decorators
TABLE = {}
def part(name, **options):
    def deco(f):
        TABLE[name] = (f, options)
        return f
    return deco
@part('a', size=2)
def build_a(k): return k * 2
@part('b')
def build_b(k): return k * 3
class Plugin:
    known = {}
    def __init_subclass__(cls, tag=None, **kw):
        super().__init_subclass__(**kw)
        Plugin.known[tag or cls.__name__] = cls
class X(Plugin, tag='x'):
    v = 1
class Y(Plugin):
    v = 2

return [f(4) for f, o in TABLE.values()], TABLE['a'][1], list(Plugin.known), Plugin.known['Y'].v
## class decorators
def add_area(cls):
    cls.area = lambda self: self.w * 2
    cls.tags = [*getattr(cls, 'tags', []), 'area']
    return cls
@add_area
class W:
    tags = ['w']
    def __init__(self, w): self.w = w

return W(4).area(), W.tags, W.__name__
## partial and reduce
from functools import partial, reduce, partialmethod
import operator
def f(a, b, c=0, *, d=1): return a * 1000 + b * 100 + c * 10 + d
p = partial(f, 1, d=7)
class B:
    def at(self, x, y): return (x, y)
    at_zero = partialmethod(at, 0)

return p(2), p(2, c=3), p(2, d=9), partial(p, 5)(6), p.args, p.keywords, reduce(lambda a, b: a * b, [1, 2, 3, 4]), reduce(operator.add, [[1], [2]], [0]), B().at_zero(5), list(map(partial(pow, 2), range(4)))
## caches
from functools import lru_cache, cache, cached_property
calls = []
@lru_cache(maxsize=None)
def fib(n):
    calls.append(n)
    return n if n < 2 else fib(n - 1) + fib(n - 2)
@lru_cache
def g(a, b=2): return a + b
@cache
def h(x): return x * 2
class C:
    n = 0
    @cached_property
    def heavy(self):
        C.n += 1
        return 42
    @lru_cache
    def m(self, x): return x + 1

c = C()
return fib(30), len(calls), g(1), g(1, b=3), h(4), c.heavy + c.heavy, C.n, c.m(3), fib.cache_info().hits
## singledispatch
from functools import singledispatch, singledispatchmethod
@singledispatch
def size(x): return 'any'
@size.register
def _(x: int): return x
@size.register(list)
def _(x): return sum(size(e) for e in x)
@size.register(str)
@size.register(tuple)
def _(x): return len(x) * 100

return size(2.5), size(3), size([1, 2]), size('abc'), size((1,)), size(True)
## generators
def count(n=0, step=1):
    while True:
        yield n
        n += step
def take(n, it):
    for _ in range(n):
        yield next(it)
def tree(depth):
    if depth == 0:
        yield 'leaf'
        return
    yield depth
    yield from tree(depth - 1)
    yield from tree(depth - 1)

g = count(5, 2)
return list(take(3, g)), next(g), list(tree(2)), sum(x for x in take(4, count())), list(zip('ab', count(1))), any(x > 3 for x in count()), next((x for x in count() if x * x > 50), None)
## lazy generators
log = []
def gen():
    log.append('start')
    yield 1
    log.append('middle')
    yield 2
    log.append('end')
    return 'r'
def outer():
    r = yield from gen()
    yield r

g = gen()
log.append('made')
a = next(g)
log.append('got')
rest = list(g)
b = list(outer())
e = next(g, 'done')
def close():
    try:
        yield 1
        yield 2
    finally:
        log.append('closed')
c = close()
next(c)
c.close()
return log, a, rest, b, e, list(c)
## generator expressions
data = [3, 1, 2]
n = 10
g = (x * n for x in data if x > 1)
n = 100
data = [9]
pairs = [(x, y) for x in range(3) for y in range(x) if (x + y) % 2]
nested = [[i * j for j in range(3)] for i in range(2)]
flat = [v for row in nested for v in row]
return list(g), pairs, nested, flat, {x % 3 for x in range(7)} == {0, 1, 2}, {k: v for k, v in zip('ab', (1, 2))}, sum(1 for _ in 'abc'), max((len(w), w) for w in ('aa', 'b')), [y := 5, y ** 2], [z for w in ('ab', 'c') if (z := w.upper()) != 'C'], dict((i, i * i) for i in range(3)), tuple(i for i in (1, 2)), [x if x % 2 else -x for x in range(4)], [a + b for a, b in [(1, 2), (3, 4)]]
## closures
def counter(start=0):
    n = start
    def step(by=1):
        nonlocal n
        n += by
        return n
    def reset():
        nonlocal n
        n = start
    return step, reset
total = 0
def bump():
    global total
    total += 5
    return total

fs = [lambda: i for i in range(3)]
gs = [lambda i=i: i for i in range(3)]
step, reset = counter(10)
s = [step(), step(4)]
reset()
def late(): return later * 2
later = 21
acc = []
for k in range(3):
    def add(x): return x + k
    acc.append(add)
return [f() for f in fs], [g() for g in gs], s, step(), bump() + bump(), late(), [f(10) for f in acc], total
## nested functions
def make(kind):
    if kind == 'a':
        def f(x): return x + 1
    elif kind == 'b':
        def f(x): return x * 2
    else:
        f = lambda x: -x
    return f
fact = lambda n: 1 if n <= 1 else n * fact(n - 1)
def even(n): return n == 0 or odd(n - 1)
def odd(n): return n != 0 and even(n - 1)
compose = lambda *fs: lambda x: x if not fs else compose(*fs[1:])(fs[0](x))

Y = lambda f: (lambda x: x(x))(lambda x: f(lambda *a: x(x)(*a)))
return [make(k)(5) for k in 'abc'], fact(6), even(10), compose(lambda x: x + 1, lambda x: x * 10)(2), Y(lambda s: lambda n: n and n + s(n - 1))(5), (lambda a, *b, c=3, **d: (a, b, c, d))(1, 2, c=4, e=5)
## arguments
def f(a, b=2, *args, c, d=4, **kw): return (a, b, args, c, d, kw)
def g(a, /, b, *, c): return (a, b, c)
def h(*args, **kw): return f(*args, **kw)

def attempt(fn, *a, **k):
    try: return fn(*a, **k)
    except TypeError as e: return str(e)
return f(1, c=3), f(1, 2, 3, 4, c=5, e=6), g(1, b=2, c=3), h(*[1, 2], *(3,), **{'c': 1}, **{'z': 2}), attempt(g, 1, 2), attempt(g, 1, 2, 3), attempt(f), attempt(g, a=1, b=2, c=3), attempt(f, 1, 2, c=1, a=3), attempt(lambda x: x), attempt(lambda x: x, 1, 2), attempt(lambda: 1, y=2)
## defaults that are shared
def add(x, seen=[]):
    seen.append(x)
    return seen
def fresh(x, seen=None):
    seen = seen or []
    seen.append(x)
    return seen
N = 3
def late(n=N): return n
N = 4

return add(1), add(2), fresh(1), fresh(2), late(), late.__defaults__ if False else N
## slices
a = list(range(10))
b = a[:]
b[2:5] = [20, 30]
c = a[:]
c[::2] = [0] * 5
d = a[:]
del d[1:4]
del d[-1], d[0]
e = a[:]
e[3:3] = ['x', 'y']
e[-2:] = []
s = 'abcdefgh'
return a[1:8:3], a[::-1], a[-3:], a[:-3], a[5:2:-1], a[20:], a[-100:2], b, c, d, e, s[::-2], s[1:-1], (1, 2, 3, 4)[1::2], a[slice(2, None, 3)], range(10)[2:8:2], list(range(10)[::-3]), slice(1, 5).indices(3)
## deletion and starred assignment
a, *b = [1, 2, 3]
*c, d = 'xyz'
e, (f, *g), h = 1, (2, 3, 4), 5
[i, j], k = (6, 7), 8
x = y = [0]
y.append(1)
m, n = 1, 2
m, n = n, m + n
table = {'a': 1, 'b': 2, 'c': 3}
del table['a']
q = [1, 2, 3, 4]
q[0], q[-1] = q[-1], q[0]
i = 0
i, q[i] = 2, 99
l = [*range(3), *'ab', *{'k': 1}]
t = {**table, 'b': 5, **{'z': 9}}
return a, b, c, d, e, f, g, h, j, k, x, m, n, table, q, l, t, (*b, 7), {*b, 2} == {2, 3}
## list methods
a = [3, 1, 2]
a.append(5); a.extend((6, 7)); a.insert(1, 9); a.remove(2)
p = a.pop(); q = a.pop(0)
b = sorted(a, key=lambda v: -v)
a.sort(reverse=True); c = a.copy(); c.reverse(); c.clear()
w = ['bb', 'a', 'ccc']
w.sort(key=len)
e = [[0] * 2] * 2
e[0][0] = 5
return a, p, q, b, c, w, e, [1, 2, 1].count(1), [5, 6].index(6), [1] + [2] * 2, [1, 2] < [1, 3], [[1, 2], [0, 5]] > [[1]], 3 in a, a.index(5), sorted('hello'), sorted({3: 1, 1: 2}), list(reversed([1, 2])), min(w, key=len), max([3, 9, 2], default=0), max([], default=-1), sorted([(1, 'b'), (1, 'a')]), [1, 2, 3].index(3, 1), list('ab') * 2
## dict methods
d = {'b': 2, 'a': 1}
d.setdefault('c', []).append(3)
d.update(z=5, a=10)
p = d.pop('b'); q = d.pop('none', None)
i = d.popitem()
e = d | {'n': 1}
e |= {'m': 2}
f = dict.fromkeys('xy', 0)
g = dict([('k', 1)], l=2)
inverse = {v: k for k, v in f.items()}
return d, p, q, i, e, f, g, inverse, list(d.keys()), list(d.values()), d.get('a'), d.get('q', 7), 'a' in d, len(d), sorted(d.items(), key=lambda kv: str(kv[1])), list(reversed({'p': 1, 'q': 2})), max({'p': 1, 'q': 2}.items(), key=lambda t: t[1]), {1: 'x', 1.0: 'y', True: 'z'}, {'a': {'b': [1]}}['a']['b'][0], d.keys() & {'a', 'zz'}, {(0, 1): 5}[0, 1], d == {'a': 10, 'c': [3]}
## set methods
a, b = {1, 2, 3, 4}, {3, 4, 5}
c = set()
c.add(2); c.update([7, 8]); c.discard(100); c.remove(7)
f = frozenset([1, 2])
return sorted(a | b), sorted(a & b), sorted(a - b), sorted(a ^ b), {1, 2} <= a, a >= {1}, {1} < {1}, a.isdisjoint({9}), sorted(c), sorted(a.union([10], (11,))), sorted(a.intersection(b, [3])), f in {f}, {f: 1}[frozenset([2, 1])], len(f | {3}), sorted({x // 2 for x in a}), a == {4, 3, 2, 1}, sorted(a.symmetric_difference(b)), bool(set()), sorted(set('hello'))
## itertools
import itertools
from itertools import product, permutations, combinations, chain, accumulate, islice, cycle, repeat, count, groupby, takewhile, dropwhile, zip_longest, pairwise, starmap, compress, tee, filterfalse, combinations_with_replacement

a, b = tee([1, 2, 3])
groups = {k: list(g) for k, g in groupby('aabbbc')}
return list(product('ab', [1, 2])), list(product(range(2), repeat=3))[5], list(permutations([1, 2, 3], 2)), list(combinations('abcd', 2))[-1], list(combinations_with_replacement([1, 2], 2)), list(chain([1], (2, 3), 'x')), list(chain.from_iterable([[1], [2]])), list(accumulate([1, 2, 3])), list(accumulate([1, 2, 3], lambda x, y: x * y, initial=10)), list(islice(count(3, 2), 2, 8, 2)), list(islice(cycle('ab'), 5)), list(repeat(7, 2)), groups, list(takewhile(lambda x: x < 3, [1, 2, 3, 1])), list(dropwhile(lambda x: x < 3, [1, 2, 3, 1])), list(zip_longest([1, 2], 'a', fillvalue=0)), list(pairwise([1, 4, 9])), list(starmap(pow, [(2, 3), (3, 2)])), list(compress('abc', [1, 0, 1])), list(a), next(b), list(filterfalse(lambda x: x % 2, range(5)))
## groupby and accumulate
from itertools import groupby, accumulate
import operator
people = [('a', 3), ('b', 3), ('c', 1)]

out = [(n, [p[0] for p in g]) for n, g in groupby(sorted(people, key=lambda p: p[1]), key=lambda p: p[1])]
runs = [(k, sum(1 for _ in g)) for k, g in groupby([1, 1, 0, 0, 0, 1])]
return out, runs, list(accumulate([3, 1, 4, 1, 5], max)), list(accumulate([2, 3], operator.mul)), list(accumulate('abc'))
## counter
from collections import Counter
c = Counter('abracadabra')
d = Counter(a=3, b=1)
d.update(['b', 'c']); d['z'] -= 1

e = Counter([1, 1, 2])
e.subtract([1])
return c.most_common(2), c['q'], sum(c.values()), sorted(c), d, sorted((Counter('aab') + Counter('ab')).items()), sorted((Counter('aab') - Counter('ab')).items()), sorted((Counter('aab') & Counter('ab')).items()), sorted((Counter('aab') | Counter('b')).items()), list(Counter('ab').elements()), c.total(), e, max(c, key=c.get), +d == Counter(a=3, b=2, c=1), dict(e)
## defaultdict
from collections import defaultdict
d = defaultdict(list)
for w in ('ab', 'ac', 'b'): d[w[0]].append(w)
n = defaultdict(int)
for ch in 'hello': n[ch] += 1
t = defaultdict(lambda: defaultdict(int))
t['x']['y'] += 5

return dict(d), n['l'], n['zz'], len(n), t['x']['y'], 'q' in d, d.get('q'), sorted(d), d['new'], list(d), defaultdict(int, a=1)['a']
## deque
from collections import deque
d = deque([1, 2, 3], maxlen=4)
d.append(4); d.append(5); d.appendleft(0)
e = deque('abc')
e.rotate(1); x = e.pop(); y = e.popleft(); e.extend('xy'); e.extendleft('pq')
q = deque([(0, 0)]); seen = {(0, 0)}
while q:
    i, j = q.popleft()
    for di, dj in ((0, 1), (1, 0)):
        n = (i + di, j + dj)
        if max(n) < 3 and n not in seen:
            seen.add(n); q.append(n)
return list(d), d[0], d[-1], len(d), d, x, y, list(e), len(seen), bool(deque()), 4 in d, list(reversed(d)), deque([1, 2]) == deque([1, 2]), d.maxlen
## ordered dict and chain map
from collections import OrderedDict, ChainMap
o = OrderedDict([('a', 1), ('b', 2), ('c', 3)])
o.move_to_end('a'); o.move_to_end('c', last=False)
m = ChainMap({'x': 1}, {'x': 2, 'y': 3})

return list(o), o.popitem(last=False), list(o.items()), m['x'], m['y'], sorted(m), m.get('q', 0), m.new_child({'y': 9})['y'], OrderedDict(a=1) == {'a': 1}
## functools and operator
import operator
from functools import cmp_to_key, reduce
from operator import itemgetter, attrgetter, methodcaller, mul
class P:
    def __init__(self, x, n): self.x, self.n = x, n
    def twice(self, k=2): return self.x * k
ps = [P(3, 'c'), P(1, 'a'), P(2, 'b')]

return [p.n for p in sorted(ps, key=attrgetter('x'))], sorted([(1, 5), (2, 3)], key=itemgetter(1)), list(map(methodcaller('twice', k=3), ps)), itemgetter(0, 2)('abc'), attrgetter('x', 'n')(ps[0]), sorted([3, 1, 2], key=cmp_to_key(lambda a, b: b - a)), reduce(mul, range(1, 6)), operator.add(1, 2), operator.lt(1, 2), operator.not_(0), operator.contains([1], 1), operator.getitem([5, 6], 1), operator.neg(3), operator.xor(5, 1), operator.truediv(7, 2), operator.concat([1], [2])
## heapq
import heapq
h = [5, 3, 8, 1]
heapq.heapify(h)
heapq.heappush(h, 2)

a = heapq.heappop(h)
return a, h, heapq.nlargest(2, [1, 5, 3]), heapq.nsmallest(2, [4, 2, 9], key=lambda v: -v), heapq.heappushpop(h, 0), heapq.heapreplace(h, 10), list(heapq.merge([1, 4], [2, 3])), [heapq.heappop(h) for _ in range(len(h))]
## dijkstra
import heapq
def shortest(graph, start):
    best = {start: 0}
    queue = [(0, start)]
    while queue:
        d, node = heapq.heappop(queue)
        if d > best[node]: continue
        for other, w in graph[node].items():
            if d + w < best.get(other, math.inf):
                best[other] = d + w
                heapq.heappush(queue, (d + w, other))
    return best

return shortest({'a': {'b': 2, 'c': 7}, 'b': {'c': 3}, 'c': {'a': 1}}, 'a'), math.inf > 5
## bisect
from bisect import bisect_left, bisect_right, insort, bisect
a = [1, 3, 3, 5]
insort(a, 4)

return a, bisect_left(a, 3), bisect_right(a, 3), bisect(a, 0), bisect([(1, 'a'), (2, 'b')], (1, 'z')), bisect_left([5, 3, 1], -3, key=lambda v: -v)
## statistics
import statistics
from statistics import mean, median, stdev, pstdev, variance, mode
d = [2, 4, 4, 4, 5, 5, 7, 9]

return mean(d), median(d), mode(d), pstdev(d), stdev(d), variance(d), statistics.fmean(d), statistics.harmonic_mean([1, 2]), statistics.quantiles(d, n=4), statistics.median_low(d), statistics.multimode('aabb'), statistics.geometric_mean([1, 4]), mean([1, 2])
## fractions
from fractions import Fraction as F
a = F(1, 3) + F(1, 6)

return a, a.numerator, float(a), F('0.125'), F(3, 6), str(F(1, 2) * 4), F(7, 2) // 1, F(1, 3) < 0.5, sum([F(1, 4)] * 4), round(F(7, 3), 1), F(0.5), a ** 2, F(22, 7).limit_denominator(5), int(F(7, 2)), f'{F(1, 3)}', abs(F(-1, 2))
## colorsys
import colorsys
from colorsys import hsv_to_rgb

return hsv_to_rgb(0.3, 0.5, 0.9), colorsys.rgb_to_hsv(0.2, 0.4, 0.6), colorsys.hls_to_rgb(0.1, 0.5, 0.8), colorsys.rgb_to_hls(0.1, 0.9, 0.3), colorsys.yiq_to_rgb(0.5, 0.1, 0.1), tuple(round(c * 255) for c in hsv_to_rgb(0.66, 1, 1))
## regular expressions
import re
m = re.match(r'(\w+)-(?P<n>\d+)', 'leg-42 x')
pattern = re.compile(r'[a-z]+', re.IGNORECASE)

return m.group(1), m['n'], int(m.group('n')), m.groups(), m.span(), re.findall(r'\d+', 'a1b22c333'), re.sub(r'\s+', ' ', 'a  b   c'), re.split(r'[,;]', 'a,b;c'), bool(re.search('z', 'abc')), pattern.findall('Ab1cD'), re.sub(r'(\w)(\d)', r'\2\1', 'a1 b2'), re.sub(r'\d', lambda m: str(int(m[0]) * 2), 'a3b4'), [m.start() for m in re.finditer('a', 'banana')], re.fullmatch('[0-9]+', '12a') is None, m.groupdict(), re.escape('a.b'), [t.group() for t in pattern.finditer('xy z')], re.match(r'(\d+)?x', 'x').groups()
## string methods
s = 'Hello, World'
return s.upper(), s.lower(), s.swapcase(), s.title(), s.capitalize(), s.find('o'), s.rfind('o'), s.find('zz'), s.index('W'), s.count('l'), s.replace('l', 'L', 2), s.split(', '), 'a b  c'.split(), 'a,b,c'.split(',', 1), 'a,b,c'.rsplit(',', 1), ' x '.strip(), 'xxaxx'.strip('x'), 'xxa'.lstrip('x'), 'axx'.rstrip('x'), s.startswith('He'), s.endswith(('x', 'ld')), '-'.join(['a', 'b']), 'a=b=c'.partition('='), 'a=b=c'.rpartition('='), 'ab'.center(6, '*'), 'ab'.ljust(4, '.'), 'ab'.rjust(4), '7'.zfill(3), '-7'.zfill(4), 'a\nb\r\nc'.splitlines(), 'abc'.isalpha(), '12'.isdigit(), 'a1'.isalnum(), ' '.isspace(), 'Ab'.isupper(), 'ab'.islower(), 'abcab'.removeprefix('ab'), 'abcab'.removesuffix('ab'), 'a\tb'.expandtabs(4), 'abc'.translate(str.maketrans('ab', 'xy')), 'abc'.translate(str.maketrans({'a': '1', 'b': None})), s[0], s[-1], 'lo' in s, s * 2, 'a' < 'b', 'é'.encode().hex() if False else 'ß'.casefold(), 'x'.isidentifier(), '½'.isnumeric()
## format specifications
x, n, s = 1234.5678, 42, 'abc'
w, p = 12, 3
return f'{x:.2f}', f'{x:10.1f}|', f'{x:<10.1f}|', f'{x:^+12.2e}|', f'{x:,.2f}', f'{n:05d}', f'{n:b}', f'{n:#x}', f'{n:o}', f'{n:X}', f'{n:c}', f'{-n:+d}', f'{n: d}', f'{n:_}', f'{1000000:_}', f'{0.25:%}', f'{0.256:.1%}', f'{s:>6}', f'{s:*^9}', f'{s:.2}', f'{x:{w}.{p}f}', f'{n!r:>5}', f'{s!r}', f'{n=}', f'{x = :.1f}', f'{{}}', f'{x:g}', f'{1e20:g}', f'{1e-7:g}', f'{True:d}', f'{n:=+8d}', f'{3.0}', f'{1e16}', f'{0.1 + 0.2}', f'{[1, 2.5]}', f'{None}', f'{"q":2}|', f'{12345678.9:n}', f'{float("inf")}', f'{5:>{w}}', f'{1+2j}', f'{n:08.3f}', f'{-0.0}', f'{x:.0f}', f'{2.5:.0f}', f'{s:{"<"}{5}}|'
## other ways to format
return '{} {}'.format(1, 'a'), '{1} {0}'.format(1, 2), '{a:>4}{b}'.format(a=1, b=[2]), '{0[1]} {1[k]}'.format([5, 6], {'k': 7}), '{:.{p}f}'.format(3.14159, p=2), '%d %s %r' % (3, 'a', 'b'), '%5.2f|%-5d|%05d' % (2.345, 7, 42), '%(n)s' % {'n': 4}, '%x %o %e' % (255, 8, 12345.678), '%%' % (), '%s' % [1], 'a' 'b', format(3.14159, '.3f'), format(255, '#b'), '{!r:>6}'.format('z'), '{:,}'.format(1234567), '{:>{}}'.format('a', 5), str(1.0), repr('it\'s'), str([1, 'a', (2,), {'k': None}]), repr(1e-5), str(10 ** 20), str(1e22), str(True), ascii('é'), chr(65) + chr(0x3b1), ord('a'), hex(255), bin(5), oct(8)
## string module
import string
from string import Template, ascii_lowercase, capwords
import textwrap

return ascii_lowercase[:3], string.digits, string.ascii_uppercase[-1], string.punctuation[:3], Template('$a and ${b}').substitute(a=1, b='x'), capwords('ab cd'), textwrap.wrap('the quick brown fox', 10), textwrap.dedent('  a\n    b'), textwrap.fill('aa bb cc', 5), textwrap.shorten('hello big world', 11), textwrap.indent('a\nb', '> '), string.hexdigits
## math
from math import *

return sqrt(2), pi, e, tau, floor(-1.5), ceil(1.2), trunc(-1.7), fabs(-2), factorial(5), gcd(12, 18), lcm(4, 6), hypot(3, 4), hypot(1, 2, 3), atan2(1, -1), degrees(pi), radians(180), exp(1), log(10), log(8, 2), log2(8), log10(1000), log1p(0.1), expm1(0.1), sin(1), cos(1), tan(1), asin(0.5), acos(0.5), atan(0.5), sinh(1), cosh(1), tanh(1), asinh(1), acosh(2), atanh(0.5), copysign(3, -0.0), fmod(-7, 3), modf(2.5), frexp(8), ldexp(0.5, 3), isclose(0.1 + 0.2, 0.3), isinf(inf), isnan(nan), prod([1, 2, 3]), comb(5, 2), perm(5, 2), dist((0, 0), (3, 4)), fsum([0.1] * 10), isqrt(17), gamma(5), lgamma(10), erf(0.5), erfc(0.5), remainder(7, 4), cbrt(27), exp2(3), ulp(1.0) > 0, nextafter(1, 2) > 1, isfinite(1), pow(2, 3)
## builtin numbers
return 7 // 2, -7 // 2, 7 % -3, -7 % 3, 7.5 // 2, -7.5 % 2, divmod(-7, 2), divmod(7.5, 2), 2 ** 10, 2 ** -1, (-8) ** 2, pow(3, 4, 5), round(2.5), round(3.5), round(2.675, 2), round(1234, -2), round(-0.5), abs(-3), int('12'), int('ff', 16), int('0b11', 2), int(-2.7), float('1e3'), float('inf') > 1, int(True), bool(''), bool([0]), 1 < 2 < 3, 1 < 3 > 2, 5 & 3, 5 | 3, 5 ^ 3, ~5, 1 << 4, 256 >> 2, 0.1 + 0.2, 10 / 4, 3 * 'ab', sum([0.1] * 10), sum([[1], [2]], []), min(3, 1, 2), max('ab'), (5).bit_length(), (0.75).as_integer_ratio(), (3.0).is_integer(), 1_000, 0xff, 1e3, 0b101, 0o17, (10).bit_count(), 7 .real, all([]), any([]), bool(0.0), not None, 3 == 3.0, hash(3) == hash(3.0), 5 or 1 / 0, 0 and 1 / 0, '' or 'x', None is None
## complex numbers
import cmath
z = 3 + 4j
w = complex(1, -2)
points = [cmath.rect(2, 2 * math.pi * k / 3) for k in range(3)]

return z.real, z.imag, abs(z), z.conjugate(), z * w, z / w, z ** 2, cmath.phase(1j), cmath.polar(z)[0], cmath.exp(1j * math.pi).real, [round(p.real, 6) for p in points], cmath.sqrt(-1), z == 3 + 4j, complex('1+2j'), -z, cmath.pi, f'{z}', z + 1, sum(points).real < 1e-9
## builtins over sequences
return list(enumerate('ab', 1)), list(zip([1, 2, 3], 'ab')), list(zip(*[(1, 2), (3, 4)])), list(map(lambda a, b: a + b, [1, 2], [10, 20])), list(filter(None, [0, 1, '', 'a'])), list(filter(lambda v: v > 1, [1, 2, 3])), list(range(5, 0, -2)), len(range(0, 10, 3)), range(3) == range(0, 3), 4 in range(0, 10, 2), any(v > 2 for v in [1, 3]), all(v for v in [1, 0]), next(iter([5])), list(iter([1, 2])), sum(map(int, '123')), sorted([3, -1, 2], key=abs), sorted('bca', reverse=True), list(reversed(range(3))), isinstance(1, (int, str)), isinstance(True, int), isinstance('a', str), type(1) is int, type([]) == list, type(2.0).__name__, callable(len), id([]) != 0, str(range(3)), tuple([1]), list(zip([1], [2], strict=True)), min([(2, 'a'), (1, 'b')]), max([1, 2], key=lambda v: -v), sum([1, 2], 10), list({'a': 1}), dict(a=1), [*map(str, (1, 2))], bytes([65, 66]).decode(), slice(1, 2)
## control flow
out = []
for i in range(10):
    if i == 2: continue
    if i == 5: break
    out.append(i)
else:
    out.append('no')
for i in []: pass
else: out.append('else')
n = 0
while True:
    n += 1
    if n > 3: break
while n > 0:
    n -= 2
else: out.append(n)
for a, (b, c) in [(1, (2, 3))]: out.append(a + b + c)
for i, x in enumerate(['p', 'q'], start=5): out.append((i, x))
for x in (y for y in range(3) if y): out.append(x)
x = 5 if out else 6
while (n := n + 1) < 3: out.append(n)
assert x == 5, 'wrong'
if not (1 > 2) and x != 4 or False: out.append('ok')
return out, x, n, i
## global tables of functions
OPS = {'+': lambda a, b: a + b, '-': lambda a, b: a - b, 'max': max}
def evaluate(tokens):
    stack = []
    for t in tokens.split():
        if t in OPS:
            b, a = stack.pop(), stack.pop()
            stack.append(OPS[t](a, b))
        else:
            stack.append(float(t))
    return stack[0]

return evaluate('3 4 + 2 -'), evaluate('1 9 max')
## l-systems
RULES = {'F': 'F+F--F+F'}
def expand(axiom, n):
    for _ in range(n):
        axiom = ''.join(RULES.get(c, c) for c in axiom)
    return axiom
def walk(text, angle=60):
    x = y = a = 0.0
    stack, path = [], []
    for c in text:
        match c:
            case 'F':
                x += math.cos(math.radians(a)); y += math.sin(math.radians(a))
                path.append((round(x, 3), round(y, 3)))
            case '+': a += angle
            case '-': a -= angle
            case '[': stack.append((x, y, a))
            case ']': x, y, a = stack.pop()
    return path

return walk(expand('F', 2)), len(expand('F', 3)), walk('F[+F]F')
## recursion with memory
def hanoi(n, a='A', b='B', c='C', moves=None):
    moves = [] if moves is None else moves
    if n:
        hanoi(n - 1, a, c, b, moves)
        moves.append(a + c)
        hanoi(n - 1, b, a, c, moves)
    return moves
def perms(items):
    if len(items) <= 1:
        yield tuple(items)
    for i, x in enumerate(items if len(items) > 1 else []):
        for rest in perms(items[:i] + items[i + 1:]):
            yield (x, *rest)
def flat(v): return [v] if not isinstance(v, list) else [y for x in v for y in flat(x)]
def ack(m, n): return n + 1 if m == 0 else ack(m - 1, 1) if n == 0 else ack(m - 1, ack(m, n - 1))

return hanoi(3), list(perms([1, 2, 3])), flat([1, [2, [3, []]], 4]), ack(2, 2)
## json, copy and types
import json, copy
from types import SimpleNamespace
ns = SimpleNamespace(a=1, b=[2])
ns.c = 5
d = {'a': [1, {'b': 2}]}
e, f = copy.copy(d), copy.deepcopy(d)
d['a'][1]['b'] = 9

return ns.a + ns.c, ns.b, json.loads('{"x": [1, 2.5, null, true]}'), json.dumps({'k': (1, 2)}), e, f, ns, vars(ns), json.dumps([1, 'a'], indent=1)
## copies of objects
import copy
class N:
    def __init__(self, v, kids=()): self.v, self.kids = v, list(kids)
    def clone(self): return copy.deepcopy(self)

a = N(1, [N(2)])
b, c = copy.copy(a), a.clone()
a.kids[0].v = 50
b.v = 7
return a.v, b.v, b.kids[0].v, c.kids[0].v, b.kids is a.kids
## random of the module
r = random
return random.random(), random.uniform(1, 5), random.randint(1, 100), random.choice([1, 2, 3, 4]), random.gauss(0, 1), random.randrange(0, 100, 5), random.triangular(0, 1, 0.3), random.betavariate(2, 3), random.expovariate(2), random.normalvariate(1, 2), sum(random.sample(range(10), 3)), sum(random.choices([1, 2, 3], k=4)), sum(random.choices([1, 2], weights=[1, 5], k=3)), random.random() < 2
## more of the random module
v = [1, 2, 3, 4, 5]
random.shuffle(v)
a = random.gammavariate(2, 3); b = random.lognormvariate(0, 1); c = random.paretovariate(3); d = random.weibullvariate(1, 2); e = random.vonmisesvariate(0, 4); f = random.getrandbits(8); g = random.choice('abc')
return v[0] * 10 + v[1], a, b, c, d, e, f, ord(g), random.random()
## random generators with a seed
from random import Random
rng = random.Random(42)
rnd = Random('text')
return rng.random(), rng.randint(1, 6), rng.choice('abc'), rng.sample(range(100), 3), rng.gauss(0, 1), rng.shuffle(x := [1, 2, 3]), x, rnd.random(), rng.choices('ab', [1, 3], k=3), rng.uniform(0, 9), rng.getrandbits(4), rng.gammavariate(1, 2), rng.lognormvariate(0, 1), rng.expovariate(1.5)
## a seed in the function
random.seed(7)
np.random.seed(3)
a = random.random(), random.randint(0, 9)
b = np.random.rand(), np.random.randint(0, 9)
random.seed(7)
return a[0], a[1], b[0], b[1], random.random()
## a seed of another kind in a variable
name, weight = 'gar' + 'den', 2.5
random.seed(name)
first = random.random(), random.randint(0, 9)
random.seed(weight)
return first[0], first[1], random.random(), random.Random(name).random(), random.Random(weight).random()
## numpy draws
return np.random.rand(), np.random.uniform(-1, 1), np.random.randint(0, 10), np.random.normal(0, 2), np.random.choice([1, 2, 5]), float(np.random.rand(3).sum()), np.random.randn(), np.random.random(), float(np.random.uniform(0, 1, (2, 2))[1, 0]), np.random.exponential(2), int(np.random.permutation(5)[0]), np.random.poisson(3)
## numpy generators
rng = np.random.default_rng(42)
old = np.random.RandomState(7)
return float(rng.random()), int(rng.integers(0, 10)), float(rng.normal()), rng.uniform(0, 1, 3).tolist(), rng.choice([1, 2, 3], size=2).tolist(), rng.permutation(4).tolist(), rng.integers(1, 7, size=(2, 2)).tolist(), float(rng.standard_normal()), rng.choice(5, 3, replace=False).tolist(), int(rng.choice(3, p=[0.1, 0.2, 0.7])), float(rng.exponential(2)), float(rng.beta(2, 3)), float(rng.gamma(2)), int(rng.poisson(4)), rng.random((2, 3)).shape, float(old.rand()), old.randint(0, 5, 3).tolist(), float(old.normal(1, 2)), old.permutation(3).tolist(), rng.triangular(0, 1, 2), rng.dirichlet([1, 2]).tolist(), rng.multivariate_normal([0, 0], [[1, 0], [0, 1]]).tolist(), rng.shuffle(a := [1, 2, 3, 4]), a, rng.lognormal(), rng.binomial(5, 0.5), old.uniform(size=2).tolist(), old.choice(4)
## numpy arrays
a = np.array([[1, 2, 3], [4, 5, 6]])
b = np.arange(6, dtype=float).reshape(2, 3)
return a.shape, a.ndim, a.size, a.T.tolist(), (a + b).tolist(), (a * 2 - 1).tolist(), (a @ b.T).tolist(), a.sum(), a.sum(axis=0).tolist(), a.mean(axis=1, keepdims=True).tolist(), a.max(), a.min(axis=1).tolist(), a.std(), b.var(axis=0).tolist(), a[1, 2], a[0].tolist(), a[:, 1].tolist(), a[-1, ::-1].tolist(), a.ravel().tolist(), a.flatten()[3], np.zeros((2, 2)).tolist(), np.ones(3).tolist(), np.full((1, 2), 7).tolist(), np.eye(2).tolist(), np.linspace(0, 1, 5).tolist(), a.tolist(), a.dtype.name, b.astype(int).tolist(), len(a), a.argmax(), a.argmin(axis=1).tolist(), a.cumsum().tolist(), np.dot([1, 2], [3, 4]), np.cross([1, 0, 0], [0, 1, 0]).tolist(), a.reshape(3, -1).tolist(), (a > 2).tolist(), a.prod(), a.any(), (a > 0).all(), 5 in a, [int(v) for v in a[0]], float(b[1][2]), repr(a), str(b), a.item(2), -a[0] % 4, a.nonzero()[0].tolist()
## numpy broadcasting
a = np.arange(3)
b = np.arange(2)
g = a[:, None] + b[np.newaxis, :] * 10
c = np.arange(24).reshape(2, 3, 4)
return g.tolist(), (a[:, None] == a).tolist(), c[..., 1].tolist(), c[0, ..., ::2].tolist(), c[:, 1, :].shape, (c - c.mean(axis=(0, 2), keepdims=True)).shape, np.sqrt(((a[:, None] - a[None]) ** 2)).tolist(), np.broadcast_to(a, (2, 3)).tolist(), np.add.outer(a, b).tolist(), c[None].shape, (a[:, None, None] * c[0, 0]).shape, np.expand_dims(a, 0).shape, np.squeeze(c[:1]).shape
## numpy masks and indices
a = np.arange(10) ** 2
m = a % 2 == 0
b = a.copy()
b[m] = -1
b[[1, 3]] = [100, 200]
c = np.arange(12).reshape(3, 4)
d = c.copy()
d[d > 5] *= 10
d[:, 0] = 7
d[1] += 1
e = np.zeros((3, 3))
e[np.arange(3), [2, 1, 0]] = 5
np.fill_diagonal(e, 9)
f = np.zeros(4)
np.add.at(f, [0, 0, 2], 1)
return a[m].tolist(), a[~m & (a > 10)].tolist(), a[[0, -1, 2]].tolist(), b.tolist(), d.tolist(), e.tolist(), c[[0, 2]][:, [1, 3]].tolist(), c[[0, 1], [2, 3]].tolist(), c[np.ix_([0, 2], [1, 2])].tolist(), np.where(a > 20)[0].tolist(), np.where(m, a, 0).tolist(), m.sum(), np.argwhere(c > 9).tolist(), np.nonzero(m)[0].tolist(), np.count_nonzero(m), (m | (a > 50)).tolist(), c[c[:, 0] > 3].tolist(), f.tolist(), np.flatnonzero(m).tolist(), a[m.nonzero()].tolist(), c[1:, 1:].sum()
## numpy views
a = np.arange(10)
v = a[2:6]
v[:] = 0
v[1] = 99
w = a.reshape(2, 5)
w[1, 4] = -5
r = a[::-1]
r[0] += 1000
c = a.copy()
c[0] = 77
t = np.zeros((2, 3)).T
t[0, 1] = 4
f = a[[7, 8]]
f[0] = 55
row = w[0]
row += 1
x = [1, 2]
arr = np.array(x)
x[0] = 9
for line in w: line[0] = 3
return a.tolist(), v.tolist(), c[0], t.tolist(), t.base is not None if False else 1, f.tolist(), arr.tolist(), w.tolist(), np.shares_memory(a, v) if False else 2, np.asarray(a) is a
## numpy functions
a = np.array([3, 1, 2, 3])
x, y = np.meshgrid([1, 2, 3], [4, 5])
u, n = np.unique(a, return_counts=True)
p, q = np.meshgrid([1, 2], [3, 4], indexing='ij')
return u.tolist(), n.tolist(), x.tolist(), y.tolist(), p.tolist(), list(np.ndindex(2, 2)), list(np.ndenumerate(np.array([[5, 6]]))), np.diag([1, 2]).tolist(), np.diag(np.eye(2)).tolist(), np.pad(a, 1).tolist(), np.pad(a, (1, 2), mode='edge').tolist(), np.pad([[1]], 1, constant_values=5).tolist(), np.roll(a, 1).tolist(), np.clip(a, 1.5, 2.5).tolist(), a.clip(0, 2).tolist(), np.interp(1.5, [0, 1, 2], [0, 10, 20]), np.interp([0.5, 3], [0, 1], [5, 6]).tolist(), np.sort(a).tolist(), np.argsort(a, kind='stable').tolist(), np.concatenate([a, [9]]).tolist(), np.stack([a, a]).shape, np.vstack([a, a]).shape, np.hstack([a, a]).tolist(), np.column_stack([a, a])[0].tolist(), np.tile([1, 2], 2).tolist(), np.repeat([1, 2], [2, 1]).tolist(), np.flip(a).tolist(), np.cumsum(a).tolist(), np.diff(a).tolist(), np.outer([1, 2], [3, 4]).tolist(), np.einsum('ij,j->i', np.eye(2), [3, 4]).tolist(), np.einsum('ii', np.eye(3)), np.isclose(0.1 + 0.2, 0.3), np.allclose([1], [1]), np.array_equal(a, a), np.digitize([0.5, 2], [0, 1, 3]).tolist(), np.histogram(a, bins=2)[0].tolist(), np.percentile(a, 50), np.median(a), np.searchsorted([1, 3, 5], 4), np.bincount([0, 1, 1]).tolist(), np.gradient([1, 4, 9]).tolist(), np.polyfit([0, 1, 2], [1, 3, 5], 1).round(6).tolist(), np.polyval([1, 2, 3], 2), np.select([a > 2, a > 1], [10, 20], 0).tolist(), np.split(np.arange(4), 2)[1].tolist(), np.rot90(np.arange(4).reshape(2, 2)).tolist(), np.average([1, 2], weights=[3, 1]), np.convolve([1, 2], [1, 1]).tolist(), np.hypot(3, 4), np.arctan2(1, 1), np.deg2rad(180), np.sign(-3), np.mod(-1, 3), np.maximum([1, 5], 3).tolist(), np.minimum.reduce([3, 1]), np.add.reduce([1, 2, 3]), np.multiply.accumulate([1, 2, 3]).tolist(), np.ptp(a), np.nan_to_num(np.nan), np.isnan([1, np.nan]).tolist(), np.trace(np.eye(3)), np.kron([1, 2], [1, 1]).tolist(), np.triu(np.ones((2, 2))).tolist(), np.mgrid[0:2, 0:2].tolist(), np.r_[1:3, 5].tolist(), np.c_[[1, 2], [3, 4]].tolist(), np.delete(a, 0).tolist(), np.insert(a, 1, 7).tolist(), np.append(a, 4).tolist(), np.vectorize(lambda v: v * 2)(a).tolist(), np.apply_along_axis(sum, 0, np.ones((2, 2))).tolist(), np.lexsort(([1, 0], [0, 0])).tolist(), np.union1d([1], [2]).tolist(), np.setdiff1d([1, 2], [2]).tolist(), np.isin([1, 2], [2]).tolist(), np.logspace(0, 2, 3).tolist(), np.round(2.567, 1), np.floor([1.5]).tolist(), np.sum([[1, 2], [3, 4]], axis=1).tolist(), np.swapaxes(np.zeros((2, 3)), 0, 1).shape, np.moveaxis(np.zeros((2, 3, 4)), 0, -1).shape, np.full_like(a, 5).tolist(), np.zeros_like(a, dtype=float).tolist(), np.indices((2, 2)).shape, np.unravel_index(5, (2, 3)), np.array_split(np.arange(5), 2)[0].tolist(), np.ravel_multi_index((1, 2), (2, 3))
## numpy linear algebra
m = np.array([[2.0, 1.0], [1.0, 3.0]])
w, v = np.linalg.eigh(m)
q, r = np.linalg.qr(m)
u, s, vt = np.linalg.svd(m)
return np.linalg.norm([3, 4]), np.linalg.norm(m, axis=1).tolist(), np.linalg.inv(m).round(8).tolist(), round(np.linalg.det(m), 8), np.linalg.solve(m, [1, 2]).round(8).tolist(), w.round(8).tolist(), np.linalg.eigvalsh(m).round(8).tolist(), np.trace(m), np.linalg.matrix_rank(m), np.linalg.matrix_power(m, 3).tolist(), np.abs(q @ r).round(6).tolist(), s.round(6).tolist(), np.linalg.lstsq(m, np.array([1, 2]), rcond=None)[0].round(6).tolist(), np.linalg.norm([1, -2, 3], ord=1), np.linalg.norm([1, -2], np.inf), np.sort(np.linalg.eig(m)[0]).round(6).tolist(), (m / np.linalg.norm(m)).round(6).tolist(), np.linalg.cond(m) > 1, np.linalg.pinv(m).round(6).tolist(), np.vdot([1, 2], [3, 4]), np.inner([1, 2], [3, 4]), np.tensordot(m, m, axes=1).tolist(), np.linalg.cholesky(m).round(6).tolist()
## numpy and objects
class V:
    def __init__(self, *c): self.a = np.array(c, dtype=float)
    def __add__(self, o): return V(*(self.a + o.a))
    def __iter__(self): return iter(self.a)
    def __array__(self, dtype=None, copy=None): return self.a
    @property
    def unit(self): return self.a / np.linalg.norm(self.a)

v = V(3, 4) + V(0, 0)
return tuple(v), v.unit.tolist(), np.sum([x for x in v]), max(v.a), sorted(np.array([3, 1])), list(map(float, v)), [f'{x:.2f}' for x in v.a], {int(k): 1 for k in v.a}, sum(v.a), bool(v.a.any()), math.sqrt(v.a[0]), round(v.a[0] / 7, 3), int(v.a[1]), range(int(v.a[0])), isinstance(v.a[0], float), isinstance(v.a, np.ndarray), v.a[0] == 3, v.a[0] is not None
## numpy noise
def smooth(n, passes):
    grid = np.random.RandomState(0).rand(n, n)
    for _ in range(passes):
        grid = (grid + np.roll(grid, 1, axis=0) + np.roll(grid, 1, axis=1)) / 3
    return grid
def game(g):
    n = sum(np.roll(np.roll(g, i, 0), j, 1) for i in (-1, 0, 1) for j in (-1, 0, 1) if (i, j) != (0, 0))
    return ((n == 3) | ((g == 1) & (n == 2))).astype(int)

g = smooth(4, 3)
glider = np.zeros((6, 6), dtype=int)
glider[[0, 1, 2, 2, 2], [1, 2, 0, 1, 2]] = 1
for _ in range(4): glider = game(glider)
return g.sum(), g[1, 2], np.argwhere(glider).tolist(), np.unravel_index(g.argmax(), g.shape)[0]
## numpy types
a = np.array([1, 2, 3], dtype=np.uint8)
b = np.float32(0.1)
return (a + 255).tolist() if False else a.dtype.itemsize, a.astype(float).dtype.name, float(b), np.int64(7) // 2, np.array([1, 2]) / 2, np.array([7, -7]) // 2, np.array([7, -7]) % 3, np.int32(5) ** 2, np.array([True, False]).sum(), np.array([1.9, -1.9]).astype(int).tolist(), np.array(['a', 'bb'])[1], str(np.float64(1.5)), repr(np.float64(1.5)), f'{np.float64(1.23456):.2f}', np.array([[1, 2], [3, 4]]).tolist(), np.empty((0, 3)).shape, np.array([]).tolist(), np.pi, np.inf > 1, np.e, np.array(5).item(), np.array([1, 2]) == [1, 3], np.bool_(True) and 1, (np.arange(4) > 1).any(), np.arange(0, 1, 0.25).tolist(), np.arange(5, 1, -2).tolist(), np.float64(2) == 2
## numpy matrices of poses
def rot(a): return np.array([[np.cos(a), -np.sin(a), 0, 0], [np.sin(a), np.cos(a), 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
def move(x, y, z):
    m = np.eye(4)
    m[:3, 3] = [x, y, z]
    return m

m = move(1, 2, 3) @ rot(0.5)
p = (m @ np.array([1, 0, 0, 1]))[:3]
pts = np.array([[0, 0, 0], [1, 1, 1]])
h = np.hstack([pts, np.ones((2, 1))])
return p.tolist(), (h @ m.T)[:, :3].round(6).tolist(), np.linalg.inv(m)[:3, 3].round(6).tolist(), np.allclose(m[:3, :3] @ m[:3, :3].T, np.eye(3)), (m[:3, :3] @ pts[1]).tolist()
## imports of all kinds
import os, sys, time
from typing import List, Dict, Tuple, Optional, Callable
from collections.abc import Iterable, Sequence
import numpy.linalg as la
from numpy import array, pi as PI
import math as m, itertools as it
from dataclasses import dataclass as dc
import collections

return m.sqrt(4), la.norm([3, 4]), array([1]).tolist(), PI, next(it.count(3)), collections.Counter('aa')['a'], isinstance([], Sequence), isinstance({}, Iterable), isinstance((), List) if False else 1
## annotations
from __future__ import annotations
x: int = 5
y: 'Missing[str]'
class A:
    v: Undefined
    w: list[Undefined] = [1]
    def f(self, a: Other = 3) -> A: return self
def g(a: int | None = None, *b: 'X', **c: Y) -> dict[str, Z]: return a or x

z: float
z = 2
return g(), A().f().w, z, A.w
## collections.abc classes
from collections.abc import Sequence, Mapping, Iterator, MutableMapping, Iterable
class Row(Sequence):
    def __init__(self, *v): self.v = v
    def __len__(self): return len(self.v)
    def __getitem__(self, i): return self.v[i]
class Table(Mapping):
    def __init__(self, **d): self.d = d
    def __getitem__(self, k): return self.d[k]
    def __iter__(self): return iter(self.d)
    def __len__(self): return len(self.d)
class Up(Iterator):
    n = 0
    def __next__(self):
        self.n += 1
        if self.n > 3: raise StopIteration
        return self.n

r, t = Row(5, 6, 7), Table(a=1, b=2)
return list(r), 6 in r, r.index(7), r.count(5), list(reversed(r)), dict(t), t.get('q', 0), list(t.items()), 'a' in t, list(Up()), isinstance(r, Iterable), len(t), {**t}, t.keys() == {'a', 'b'}
## subclasses of containers
class Grid(dict):
    def __missing__(self, k):
        self[k] = k * 2
        return self[k]
    def total(self): return sum(self.values())
class Path(list):
    def last(self): return self[-1]
    def add(self, v):
        self.append(v)
        return self
class Up(str):
    def shout(self): return self.upper() + '!'
class Pt(tuple):
    def __new__(cls, x, y): return super().__new__(cls, (x, y))
    @property
    def x(self): return self[0]

g = Grid(a='z')
g[3]
p = Path([1]).add(2)
return g, g[5], g.total() if False else len(g), p, p.last(), isinstance(p, list), Up('ab').shout(), Pt(3, 4).x, Pt(1, 2) == (1, 2), p + [3], len(Path())
## descriptors
class Positive:
    def __set_name__(self, owner, name): self.name = '_' + name
    def __get__(self, obj, owner=None): return self if obj is None else getattr(obj, self.name)
    def __set__(self, obj, value):
        if value <= 0: raise ValueError(f'{self.name} must be positive')
        setattr(obj, self.name, value)
class Box:
    w = Positive()
    h = Positive()
    def __init__(self, w, h): self.w, self.h = w, h

b = Box(2, 3)
b.w = 10
try: b.h = -1
except ValueError as e: text = str(e)
return b.w * b.h, text, b._w
## singletons and class state
class Registry:
    _instance = None
    items = {}
    def __new__(cls, *a, **k):
        if cls._instance is None:
            cls._instance = super().__new__(cls)
            cls._instance.n = 0
        return cls._instance
    def add(self, k, v):
        self.items[k] = v
        self.n += 1
        return self

Registry().add('a', 1).add('b', 2)
return Registry().n, Registry().items, Registry() is Registry()
## builder and chaining
class Builder:
    def __init__(self): self.parts = []; self._at = (0, 0)
    def at(self, x, y):
        self._at = (x, y)
        return self
    def put(self, kind, **opts):
        self.parts.append({'kind': kind, 'at': self._at, **opts})
        return self
    def build(self): return tuple(self.parts)
    def __or__(self, other):
        b = Builder()
        b.parts = self.parts + other.parts
        return b
    def __lshift__(self, kind): return self.put(kind)
    def __rrshift__(self, kind): return self.put(kind + '!')

return (Builder().at(1, 2).put('a', size=3).at(4, 5).put('b').build()), len((Builder().put('x') | Builder().put('y')).parts), (Builder() << 'z').parts[0]['kind'], ('w' >> Builder()).parts[0]['kind']
## trees of objects
from __future__ import annotations
from dataclasses import dataclass, field
from typing import Iterator, Optional
@dataclass
class Node:
    value: int
    left: Optional[Node] = None
    right: Node | None = None
    def insert(self, v):
        side = 'left' if v < self.value else 'right'
        child = getattr(self, side)
        if child is None: setattr(self, side, Node(v))
        else: child.insert(v)
    def __iter__(self) -> Iterator[int]:
        if self.left: yield from self.left
        yield self.value
        if self.right: yield from self.right
    @property
    def depth(self): return 1 + max((n.depth for n in (self.left, self.right) if n), default=0)

root = Node(5)
for v in (2, 8, 1, 9, 3): root.insert(v)
return list(root), root.depth, 8 in root, sum(root), root.left.value, [a + b for a, b in zip(root, list(root)[1:])]
## linked list
class Cell:
    def __init__(self, v, next=None): self.v, self.next = v, next
class Linked:
    def __init__(self, items=()):
        self.head = None
        for v in reversed(list(items)): self.head = Cell(v, self.head)
    def __iter__(self):
        c = self.head
        while c:
            yield c.v
            c = c.next
    def __len__(self): return sum(1 for _ in self)
    def __repr__(self): return ' -> '.join(map(str, self))
    def reverse(self):
        prev, c = None, self.head
        while c: c.next, prev, c = prev, c, c.next
        self.head = prev

l = Linked([1, 2, 3])
l.reverse()
return list(l), len(l), repr(l), bool(Linked())
## strategies and callbacks
from typing import Callable
from dataclasses import dataclass, field
@dataclass
class Style:
    fn: Callable[[float], float] = abs
    hooks: list[Callable] = field(default_factory=lambda: [str])
class Bus:
    def __init__(self): self.subs = {}
    def on(self, name):
        def deco(f):
            self.subs.setdefault(name, []).append(f)
            return f
        return deco
    def emit(self, name, *a): return [f(*a) for f in self.subs.get(name, [])]
bus = Bus()
@bus.on('x')
def one(v): return v + 1
@bus.on('x')
def two(v): return v * 2

return Style().fn(-3), Style(fn=lambda t: t * t).fn(5), Style().hooks[0](7), bus.emit('x', 10), bus.emit('none')
## state machines
from enum import Enum, auto
class S(Enum):
    IDLE = auto(); RUN = auto(); DONE = auto()
NEXT = {S.IDLE: S.RUN, S.RUN: S.DONE}
TABLE = {(S.IDLE, 'go'): S.RUN, (S.RUN, 'stop'): S.DONE}

s, seen = S.IDLE, []
while s in NEXT:
    seen.append(s.name)
    s = NEXT[s]
t = S.IDLE
for event in ('x', 'go', 'stop'): t = TABLE.get((t, event), t)
return seen, s.name, t.value, [x.name for x in S if x is not S.RUN], S.RUN.name.lower(), list(S).index(S.DONE)
## walrus and conditions
import re
data = [1, 5, 12]
if (n := len(data)) > 2: big = n
while (v := data.pop()) > 4: last = v
found = [y for x in (1, 2, 3) if (y := x * x) > 3]
if m := re.match(r'(\d+)', '42abc'): num = int(m[1])
return big, v, last, found, num, y, (lambda q: (r := q + 1) * r)(3), any((w := z) > 2 for z in [1, 3, 5]), w
## chained comparisons and booleans
log = []
def t(v):
    log.append(v)
    return v

a = t(1) < t(2) < t(0) < t(9)
b = t(0) or t(5) or t(6)
c = t(1) and t(0) and t(7)
d = not t('') and 'yes'
e = t(3) if t(False) else t(4)
return a, b, c, d, e, log, 1 == 1.0 == True, [] is not [], 1 in [1] == True, None or [], 0 == False, 'a' 'b' == 'ab'
## unpacking in calls and returns
def minmax(*v): return min(v), max(v)
def split(n): return divmod(n, 10)
def opts(*, size=1, **rest): return size, sorted(rest)

lo, hi = minmax(*[3, 1, 2])
d = {'size': 4, 'b': 1}
(a, b), c = split(47), [*split(35)]
return lo, hi, opts(**d), opts(**{**d, 'size': 9}), a, b, c, print('x', end='') is None, max(*[1, 2], 3), minmax(*range(3), *(9,))
## sorting
people = [('bob', 25), ('al', 30), ('cy', 25)]
people.sort(key=lambda p: (-p[1], p[0]))
words = ['Banana', 'apple', 'cherry']
return people, sorted(words, key=str.lower), sorted(words, key=len, reverse=True), sorted(people, key=lambda p: p[1]), sorted([0.5, -1, 2], key=lambda x: x ** 2), sorted({'b': 1, 'a': 2}.items()), sorted([True, False, True]), sorted([[2, 1], [1, 9]]), list(map(str.upper, words)), sorted(range(5), key=lambda i: (i % 2, -i)), [w for _, w in sorted(zip([3, 1, 2], words))], max(words, key=lambda w: w.count('a'))
## bytes
b = b'abc'
return b[0], len(b), list(b), b.decode(), 'é'.encode('utf-8')[0], bytes(2), bytearray([1, 2])[1], b'ab' + b'c' == b, b[1:].hex(), int.from_bytes(b'\x01\x00', 'big')
## hashes of texts
import hashlib, zlib
n = int(hashlib.md5(b'oak').hexdigest(), 16) % 100

return n, zlib.crc32(b'abc') % 1000, hash((1, 2)) == hash((1, 2)), hash(5)
## printing
print('a', 1, [2], sep='-', end='!\n')
print(f'{3:>4}')
return print(), 5
## type checks
def kind(v):
    if isinstance(v, bool): return 'bool'
    if isinstance(v, (int, float)): return 'number'
    if isinstance(v, str): return 'text'
    if isinstance(v, dict): return 'dict'
    if callable(v): return 'function'
    if v is None: return 'none'
    if hasattr(v, '__iter__'): return 'iterable'
    return type(v).__name__

return [kind(v) for v in (True, 1, 2.5, 'a', {}, len, None, [1], (1,), {1}, 1j, lambda: 0, int, object())], type('a').__name__, type(None).__name__, type(kind).__name__, isinstance(int, type), isinstance(kind, type(kind)), issubclass(bool, int), int.__name__, isinstance(1, int | str), type(1) in (int, float), str(type(1)), type([1]) is type([])
## functions as objects
def f(a, b=2):
    "doc"
    return a + b
f.count = 0
f.count += 1
g = f
class K:
    def m(self): return 5
    n = lambda self: 6

k = K()
bound = k.m
return f.__name__, f.__doc__, f.count, g is f, bound(), K.m(k), k.n(), (lambda: 0).__name__, bound.__name__, [h(3) for h in (f, abs, lambda x: -x)], {'f': f}['f'](1), K.__doc__ is None, f.__defaults__, bound.__self__ is k
## objects in sets and tables
class P:
    def __init__(self, x, y): self.x, self.y = x, y
    def __eq__(self, o): return isinstance(o, P) and (self.x, self.y) == (o.x, o.y)
    def __hash__(self): return hash((self.x, self.y))
    def __repr__(self): return f'P{self.x, self.y}'
class Q:
    pass

s = {P(1, 2), P(1, 2), P(3, 4)}
d = {P(0, 0): 'o'}
q = Q()
return len(s), P(3, 4) in s, d[P(0, 0)], P(1, 2) == (1, 2), {q: 1}[q], Q() == Q(), [P(1, 1)].index(P(1, 1)), [P(1, 1)].count(P(1, 1)), sorted(s, key=lambda p: p.x), P(1, 2) in [P(1, 2)]
## private names
class A:
    __secret = 5
    def __init__(self): self.__x = 1; self._y = 2
    def get(self): return self.__x + self.__secret
class B(A):
    def __init__(self):
        super().__init__()
        self.__x = 100
    def own(self): return self.__x

b = B()
return b.get(), b.own(), b._y, b._A__x, sorted(vars(b))
## nested classes
class Outer:
    SIZE = 3
    class Inner:
        v = 7
        def get(self): return Outer.SIZE + self.v
    class Kind:
        A, B = 1, 2
    DOUBLED = SIZE * 2
    LIST = [SIZE] * 2
    def make(self): return self.Inner()

return Outer().make().get(), Outer.Kind.B, Outer.DOUBLED, Outer.LIST, Outer.Inner.__name__
## inner classes of functions
def make(n):
    class Local:
        size = n
        def twice(self): return self.size * n
    return Local

A, B = make(2), make(5)
return A().twice(), B().twice(), A is B, A.__name__
## getattr dispatch
class Visitor:
    def visit(self, node, *a): return getattr(self, f'visit_{type(node).__name__}', self.default)(node, *a)
    def default(self, node): return 'default'
    def visit_int(self, n): return n + 1
    def visit_list(self, l): return [self.visit(x) for x in l]
    def visit_Leaf(self, leaf): return leaf.v
class Leaf:
    v = 'leaf'

for name, value in (('a', 1), ('b', 2)): setattr(Leaf, name, value)
obj = Leaf()
setattr(obj, 'c', 3)
return Visitor().visit([1, 'x', Leaf(), [2]]), Leaf.a, obj.b, obj.c, [getattr(obj, n) for n in 'abc'], delattr(obj, 'c'), hasattr(obj, 'c')
## generators as coroutines of steps
def walk():
    x = 0
    while x < 3:
        x += 1
        yield x
    return 'end'
def both(a, b):
    for x, y in zip(a, b):
        yield x
        yield y
def pipeline(data):
    doubled = (x * 2 for x in data)
    kept = (x for x in doubled if x % 3)
    yield from enumerate(kept)
def window(seq, n):
    it = iter(seq)
    from collections import deque
    d = deque((next(it, None) for _ in range(n)), maxlen=n)
    yield tuple(d)
    for x in it:
        d.append(x)
        yield tuple(d)

return list(both(walk(), 'abc')), list(pipeline(range(6))), list(window([1, 2, 3, 4], 2)), [*walk()], dict(enumerate(walk())), (lambda g: (next(g), next(g)))(walk()), list(map(sum, zip(walk(), walk())))
## infinite generators
from itertools import islice, takewhile
def primes():
    found = []
    n = 2
    while True:
        if all(n % p for p in found):
            found.append(n)
            yield n
        n += 1
def fib():
    a, b = 0, 1
    while True:
        yield a
        a, b = b, a + b

return list(islice(primes(), 8)), list(takewhile(lambda x: x < 50, fib())), next(p for p in primes() if p > 20), [next(g) for g in [fib()] for _ in range(3)], sum(islice((x for x in fib() if x % 2 == 0), 5))
## iterators by hand
it = iter([1, 2, 3])
a = next(it)
rest = list(it)
calls = iter([5, 3, 0, 9])
until = list(iter(lambda: next(calls), 0))
z = zip(*[iter(range(6))] * 2)
e = enumerate('ab')
d = iter({'k': 1}.items())
try:
    next(iter([]))
except StopIteration:
    stopped = True
m = map(str, [1, 2])
return a, rest, until, list(z), next(e), list(e), next(d), stopped, next(m), list(m), list(m), next(reversed([1, 2])), iter(it) is it
## interpolation and easing
def lerp(a, b, t): return a + (b - a) * t
def ease(t, kind='in_out'):
    match kind:
        case 'in': return t ** 2
        case 'out': return 1 - (1 - t) ** 2
        case _: return 3 * t ** 2 - 2 * t ** 3
def bezier(p, t):
    while len(p) > 1: p = [tuple(lerp(a, b, t) for a, b in zip(u, v)) for u, v in zip(p, p[1:])]
    return p[0]
def catmull(p0, p1, p2, p3, t): return 0.5 * (2 * p1 + (p2 - p0) * t + (2 * p0 - 5 * p1 + 4 * p2 - p3) * t * t + (3 * p1 - p0 - 3 * p2 + p3) * t ** 3)

return lerp(0, 10, 0.3), [ease(0.25, k) for k in ('in', 'out', 'x')], bezier([(0, 0), (1, 2), (3, 0)], 0.5), catmull(0, 1, 2, 3, 0.5)
## grids and neighbours
W, H = 4, 3
grid = [['.'] * W for _ in range(H)]
for r, c in [(0, 1), (2, 3)]: grid[r][c] = '#'
def near(r, c): return [(r + a, c + b) for a in (-1, 0, 1) for b in (-1, 0, 1) if (a, b) != (0, 0) and 0 <= r + a < H and 0 <= c + b < W]
def fill(r, c, seen):
    if (r, c) in seen or grid[r][c] == '#': return 0
    seen.add((r, c))
    return 1 + sum(fill(*n, seen) for n in near(r, c))

return [''.join(row) for row in grid], near(0, 0), fill(0, 0, set()), list(zip(*grid))[1], [*map(list, zip(*grid))][3], [row[::-1] for row in grid], sum(row.count('#') for row in grid)
## mazes
class Maze:
    def __init__(self, n, seed):
        self.n, self.rng = n, random.Random(seed)
        self.open = set()
        self._carve((0, 0), {(0, 0)})
    def _carve(self, cell, seen):
        steps = [(1, 0), (-1, 0), (0, 1), (0, -1)]
        self.rng.shuffle(steps)
        for dx, dy in steps:
            new = cell[0] + dx, cell[1] + dy
            if new not in seen and all(0 <= v < self.n for v in new):
                seen.add(new)
                self.open.add(frozenset((cell, new)))
                self._carve(new, seen)

m = Maze(4, 1)
return len(m.open), sorted(tuple(sorted(e)) for e in m.open)
## arguments of draws
return random.choice([[1, 2], [3, 4]])[0], random.uniform(*sorted([3, 1])), random.randint(a=1, b=3), random.sample([1, 2, 3], k=2)[0], random.choices([1, 2], cum_weights=[1, 3])[0], np.random.choice(4, p=[0.1, 0.2, 0.3, 0.4]), float(np.random.normal(loc=1, scale=2, size=3)[2]), int(np.random.randint(low=1, high=5, size=(2,))[0]), random.choice(range(5))
## draws that decide
n = 0
out = []
for i in range(6):
    if random.random() < 0.5: n += 1
    elif np.random.rand() > 0.3: out.append(random.choice(['a', 'b']))
    else: break
kind = random.choice(['big', 'small'])
while random.random() < 0.7: n += 10
v = list(range(5))
random.shuffle(v)
return n, out, {'big': 3, 'small': 4}[kind], v, random.sample(v, 3), np.random.permutation(3).tolist()
## draws of objects
from enum import Enum
from dataclasses import dataclass
class Kind(Enum):
    A = 1
    B = 2
@dataclass
class Tree:
    h: float
    kind: Kind
def grow(n): return [Tree(random.uniform(1, 2), random.choice(list(Kind))) for _ in range(n)]

t = grow(4)
return [round(x.h, 6) for x in t], [x.kind.name for x in t], max(t, key=lambda x: x.h).h, sum(x.h for x in t if x.kind is Kind.A)
## eval order of arguments
log = []
def t(v):
    log.append(v)
    return v
class A:
    def __getitem__(self, k): return k
    def __setitem__(self, k, v): log.append((k, v))

a = A()
a[t(1)] = t(2)
d = {t(3): t(4), t(5): t(6)}
x = [t(7), *[t(8)], t(9)]
def f(*p, **k): return len(p) + len(k)
n = f(t(10), *[t(11)], k=t(12), **{'z': t(13)})
a[t(14)] += t(15) if False else [t(16)][0] if False else 0
return log, n
## augmented assignment
class Acc:
    def __init__(self): self.v = [1]; self.n = {'k': 1}
a = Acc()
x = y = [1]
x += [2]
t = u = (1,)
t += (2,)
s = 'a'; s *= 3
n = 7; n //= 2; n **= 2; n -= 1; n %= 5; n <<= 3; n |= 1; n ^= 2; n &= 30; n >>= 1
f = 1.5; f /= 2
a.v += [5]; a.v[0] += 10; a.n['k'] *= 4

grid = [[0] * 2 for _ in range(2)]
grid[1][0] += 3
b = {1}; b |= {2}; b -= {1}
return x, y, t, u, s, n, f, a.v, a.n, grid, b
## scopes of comprehensions
x = 5
squares = [x * x for x in range(3)]
class K:
    n = 4
    items = [i * 2 for i in range(n)]

fs = [(lambda: x) for x in range(2)]
m = [[(a, b) for b in range(a)] for a in range(3)]
return squares, K.items, [f() for f in fs], m, [a for a in [1] for a in [a + 1]], {a: [b for b in range(a)] for a in (1, 2)}
## late binding of generators
n = 1
g = (n * i for i in range(3))
n = 10
out = list(g)
def make():
    k = 2
    h = (k + i for i in range(2))
    k = 50
    return list(h)
items = [1, 2, 3]
lazy = map(lambda v: v * n, items)
n = 100
items.append(4)

return out, make(), list(lazy), list(zip(items, (i for i in items if i > 1)))
## booleans as numbers
return True + True, sum([True, False, True]), [10, 20][True], 3 * False, True / 2, int(True), float(True), str(True), True == 1, True is True, isinstance(True, int), max(True, 0), round(True), -True, ~True, True << 2, f'{True}', f'{True:d}', 'ab'[True], range(3)[True], {1: 'a'}[True], sorted([True, 0, 2]), abs(True), divmod(7, True), True & False, True | False, not True
## integer and float
return 7 / 2, 6 / 2, 2 ** 0.5, 10 ** 20, 2 ** 100 % 7, 1e308 * 10 > 1, 5 // 0.3, -5 % 0.3, int(1e18), 0.1 * 3, 1 / 3, round(1 / 3, 4), round(12345.678, -2), int('-7'), float(' 2.5 '), 3 .__add__(4), (2.5).__round__(), 5 == 5.0, hash(1.0) == 1, 1.0.is_integer(), float('nan') != float('nan'), min(1, 1.0), max(1, 1.0), round(0.5), round(1.5), round(-2.5), int(-0.9), math.floor(-0.9), -7 // 2.0, 7 // -2, 0.1 + 0.7, 3.7 % 1, -3.7 % 1, divmod(-3.7, 1), pow(2, 0.5), pow(2, -1), complex(1).real, 1 if 0.0 else 2, str(0.1 + 0.2), str(1e-7), repr(100000000000000000.0)
## strings as sequences
s = 'scene'
return list(s), s[::-1], s[1:3], sorted(s), ''.join(sorted(set(s))), [ord(c) - 96 for c in s], s.index('e'), 'e' in s, [i for i, c in enumerate(s) if c == 'e'], max(s), min(s), len(s), s * 2, 'a' + s, s > 'abc', {c: s.count(c) for c in s}, list(zip(s, s[1:])), list(map(ord, 'ab')), tuple('ab'), any(c.isupper() for c in s), s[len(s) // 2], '\n'.join(['a', 'b']).split('\n'), """a
b""".splitlines(), r'\n', 'tab\t'.strip(), "it's", 'x' if s else 'y', s and s[0], not s, chr(ord('a') + 2), str(5) + '5', int('5') + 5, '5' * 3, '%s-%s' % ('a', 1), 'a,b'.split(',')[-1], 'abc'.find('c'), ' '.join(w.capitalize() for w in 'the red fox'.split())
## ascii art maps
MAP = """
#..#
.##.
@..#
""".strip().splitlines()
LEGEND = {'#': 2, '@': 5, '.': 0}
def cells():
    for z, row in enumerate(MAP):
        for x, ch in enumerate(row):
            if h := LEGEND.get(ch):
                yield x, z, h

return list(cells()), {(x, z): h for x, z, h in cells()}[(0, 2)], max(cells(), key=lambda c: c[2])
## tables of settings
from types import MappingProxyType
CONFIG = {'trees': {'count': 3, 'kinds': ['oak', 'pine']}, 'lake': {'r': 2.5, **{'depth': 1}}}
LIMITS = MappingProxyType({'low': 1, 'high': 9})
def get(path, default=None):
    node = CONFIG
    for key in path.split('.'):
        if not isinstance(node, dict) or key not in node: return default
        node = node[key]
    return node

return get('trees.count'), get('lake.depth'), get('lake.x', 'no'), get('trees.kinds')[1], LIMITS['high'], sorted(LIMITS), [*CONFIG], len(CONFIG['lake'])
## frozen keys and enums as keys
from enum import Enum
from dataclasses import dataclass
class Mat(Enum):
    WOOD = 'wood'
    STONE = 'stone'
@dataclass(frozen=True)
class Cell:
    x: int
    y: int
    def __add__(self, o): return Cell(self.x + o.x, self.y + o.y)
COLORS = {Mat.WOOD: (.4, .3, .1), Mat.STONE: (.5, .5, .5)}

grid = {Cell(0, 0): Mat.WOOD, Cell(1, 0): Mat.STONE}
near = {c + Cell(1, 0) for c in grid}
return COLORS[Mat('stone')], grid[Cell(1, 0)].value, Cell(2, 0) in near, len(near | set(grid)), sorted(near, key=lambda c: (c.x, c.y)), {m.value: n for n, m in enumerate(Mat)}, [m for m in Mat if m in COLORS][0].name
## abstract factory
from abc import ABC, abstractmethod
from typing import ClassVar
class Plant(ABC):
    registry: ClassVar[dict[str, type]] = {}
    def __init_subclass__(cls, **kw):
        super().__init_subclass__(**kw)
        cls.registry[cls.__name__.lower()] = cls
    def __init__(self, height: float = 1.0) -> None: self.height = height
    @abstractmethod
    def parts(self) -> list: ...
    @classmethod
    def create(cls, kind: str, **kw) -> 'Plant': return cls.registry[kind](**kw)
    def size(self): return sum(self.parts())
class Oak(Plant):
    def parts(self): return [self.height, self.height / 2]
class Fern(Plant):
    def __init__(self, fronds=3, **kw):
        super().__init__(**kw)
        self.fronds = fronds
    def parts(self): return [self.height] * self.fronds

return Plant.create('oak', height=4).size(), Plant.create('fern', fronds=5).size(), sorted(Plant.registry), [type(Plant.create(k)).__name__ for k in Plant.registry]
## composite and visitor
from __future__ import annotations
from abc import ABC, abstractmethod
class Node(ABC):
    @abstractmethod
    def accept(self, v: Visitor): ...
class Leaf(Node):
    def __init__(self, w): self.w = w
    def accept(self, v): return v.leaf(self)
class Group(Node):
    def __init__(self, *kids): self.kids = kids
    def accept(self, v): return v.group(self)
class Visitor:
    def leaf(self, l): return l.w
    def group(self, g): return sum(k.accept(self) for k in g.kids)
class Depth(Visitor):
    def leaf(self, l): return 1
    def group(self, g): return 1 + max(k.accept(self) for k in g.kids)

t = Group(Leaf(2), Group(Leaf(3), Leaf(4)))
return t.accept(Visitor()), t.accept(Depth())
## matrices by hand
class M:
    def __init__(self, rows): self.rows = [list(r) for r in rows]
    def __matmul__(self, o): return M([[sum(a * b for a, b in zip(r, c)) for c in zip(*o.rows)] for r in self.rows])
    def __getitem__(self, ij):
        i, j = ij
        return self.rows[i][j]
    def __setitem__(self, ij, v): self.rows[ij[0]][ij[1]] = v
    @classmethod
    def identity(cls, n): return cls([[int(i == j) for j in range(n)] for i in range(n)])
    @property
    def T(self): return M(zip(*self.rows))
    def __iter__(self): return (v for r in self.rows for v in r)
    def __pow__(self, n): return M.identity(len(self.rows)) if n == 0 else self @ self ** (n - 1)

m = M([[1, 1], [1, 0]])
m2 = m ** 5
m2[0, 0] = 100
return list(m ** 8), m2[0, 0], list(m.T), list(M.identity(2) @ m), sum(m)
## turtles
class Turtle:
    def __init__(self): self.x = self.y = 0.0; self.a = 0; self.trail = [(0.0, 0.0)]; self.stack = []
    def forward(self, d):
        self.x += d * math.cos(math.radians(self.a)); self.y += d * math.sin(math.radians(self.a))
        self.trail.append((round(self.x, 4), round(self.y, 4)))
        return self
    def left(self, a):
        self.a = (self.a + a) % 360
        return self
    def __enter__(self):
        self.stack.append((self.x, self.y, self.a))
        return self
    def __exit__(self, *exc): self.x, self.y, self.a = self.stack.pop()

t = Turtle()
for _ in range(4): t.forward(2).left(90)
with t: t.left(45).forward(1)
return t.trail, t.a, t.x
## particles and steps
from dataclasses import dataclass, field, replace
@dataclass
class P:
    pos: np.ndarray
    vel: np.ndarray
    age: int = 0
    def step(self, dt=0.1):
        self.vel = self.vel + np.array([0, -9.8]) * dt
        self.pos = self.pos + self.vel * dt
        if self.pos[1] < 0: self.pos[1] *= -0.5; self.vel[1] *= -0.5
        self.age += 1
        return self
@dataclass
class World:
    ps: list[P] = field(default_factory=list)
    def run(self, n):
        for _ in range(n):
            for p in self.ps: p.step()
        return [tuple(p.pos.round(4)) for p in self.ps]

return World([P(np.array([0., 1.]), np.array([1., 0.])), P(np.zeros(2), np.array([0.5, 3.]))]).run(12)
## quaternions
from dataclasses import dataclass
@dataclass(frozen=True)
class Q:
    w: float; x: float; y: float; z: float
    def __mul__(s, o):
        return Q(s.w*o.w - s.x*o.x - s.y*o.y - s.z*o.z, s.w*o.x + s.x*o.w + s.y*o.z - s.z*o.y, s.w*o.y - s.x*o.z + s.y*o.w + s.z*o.x, s.w*o.z + s.x*o.y - s.y*o.x + s.z*o.w)
    @staticmethod
    def about(axis, a): return Q(math.cos(a / 2), *(math.sin(a / 2) * c for c in axis))
    def inverse(self): return Q(self.w, -self.x, -self.y, -self.z)
    def turn(self, v):
        r = self * Q(0, *v) * self.inverse()
        return r.x, r.y, r.z

return Q.about((0, 0, 1), math.pi / 2).turn((1, 0, 0)), (Q.about((0, 1, 0), .5) * Q.about((1, 0, 0), .25)).turn((1, 2, 3))
## colour classes
from typing import NamedTuple
import colorsys
class RGB(NamedTuple):
    r: float
    g: float
    b: float
    @classmethod
    def hex(cls, text): return cls(*(int(text.lstrip('#')[i:i + 2], 16) / 255 for i in (0, 2, 4)))
    def mix(self, o, t=0.5): return RGB(*(a + (b - a) * t for a, b in zip(self, o)))
    def lighter(self, k=1.2): return self._replace(**{n: min(1, v * k) for n, v in self._asdict().items()})
    @property
    def hsv(self): return colorsys.rgb_to_hsv(*self)
    def __str__(self): return '#' + ''.join(f'{round(c * 255):02x}' for c in self)

c = RGB.hex('#336699')
return c, c.mix(RGB(1, 1, 1)), c.lighter(), c.hsv, str(c), f'{c}', '%s' % (c,)
## polynomial noise
class Noise:
    def __init__(self, seed=0):
        p = list(range(256))
        random.Random(seed).shuffle(p)
        self.p = p * 2
    def __call__(self, x, y):
        xi, yi = int(math.floor(x)) & 255, int(math.floor(y)) & 255
        u, v = (self.fade(t - math.floor(t)) for t in (x, y))
        h = [self.p[self.p[xi + i] + yi + j] / 255 for i in (0, 1) for j in (0, 1)]
        return self.lerp(u, self.lerp(v, h[0], h[1]), self.lerp(v, h[2], h[3]))
    @staticmethod
    def fade(t): return t * t * t * (t * (t * 6 - 15) + 10)
    @staticmethod
    def lerp(t, a, b): return a + t * (b - a)
def fbm(n, x, y, octaves=3): return sum(n(x * 2 ** i, y * 2 ** i) / 2 ** i for i in range(octaves))

n = Noise(3)
return [round(fbm(n, i * .3, i * .7), 6) for i in range(6)]
## priority of operators
a, b, c = 2, 3, 4
return a + b * c, (a + b) * c, -a ** 2, (-a) ** 2, a ** b ** 2, not a == b, a < b == True, a if b else c, (lambda: 1 if a else 2)(), a | b & c, a ^ b | c, ~a + 1, a << 1 + 1, a - b - c, c / a / b, a * b % c, c % a * b, 2 ** -1, -7 // 2, not 1 or 2, 1 and 0 or 3, [1, 2][-1:][0], a in [2] and b not in [2], 1 < 2 > 1 != 3
## exceptions in generators
def g():
    try:
        yield 1
        raise ValueError('x')
    except ValueError as e:
        yield str(e)
    finally:
        yield 'end'
def h():
    yield 1
    return 5
class Stop(Exception): pass
def k():
    for i in range(5):
        if i == 2: raise Stop(i)
        yield i

out = []
try:
    for v in k(): out.append(v)
except Stop as e: out.append(('stop', *e.args))
r = h()
next(r)
try: next(r)
except StopIteration as e: out.append(e.value)
return list(g()), out
## errors of many kinds
def kind(f):
    try: return f()
    except Exception as e: return type(e).__name__, str(e)

return [kind(f) for f in (lambda: 1 / 0, lambda: 1 % 0, lambda: 1 // 0.0, lambda: [][0], lambda: {}['a'], lambda: int('z'), lambda: float('q'), lambda: 'a' + 1, lambda: 1 + 'a', lambda: [1] + (2,), lambda: len(5), lambda: None + 1, lambda: (1, 2).x, lambda: 'abc'.nope(), lambda: [1, 2, 3].index(9), lambda: (1).foo, lambda: max([]), lambda: next(iter([])), lambda: 'abc'[10], lambda: (1, 2)[5], lambda: int(None), lambda: sum(['a']), lambda: sorted([1, 'a']), lambda: 1 < 'a', lambda: {[]: 1}, lambda: set([[]]), lambda: math.sqrt(-1), lambda: math.log(0), lambda: [].pop(), lambda: {}.pop('k'), lambda: ''.join([1]), lambda: abs('a'), lambda: range(1.5), lambda: round('a'), lambda: chr(-1), lambda: ord('ab'), lambda: 'a' * 'b', lambda: [1, 2][1.0], lambda: 5(), lambda: zip([1], [2, 3], strict=True).__next__ and list(zip([1], [2, 3], strict=True)), lambda: [1].remove(5), lambda: int('1.5'), lambda: dict([1]), lambda: tuple(5), lambda: -'a', lambda: not_defined, lambda: math.factorial(-1), lambda: 'x' in 5, lambda: f'{1:q}', lambda: random.choice([]), lambda: np.zeros(2)[5], lambda: np.array([1, 2]) + np.array([1, 2, 3]), lambda: 10 ** 400 * 1.0)]
## unpacking errors
def attempt(f):
    try: return f()
    except (ValueError, TypeError) as e: return str(e)
def two():
    a, b = [1, 2, 3]
def three():
    a, b, c = 1, 2
def star():
    a, *b, c = [1]
def number():
    a, b = 5
def none():
    for a, b in [(1, 2), (3,)]: pass

return [attempt(f) for f in (two, three, star, number, none)]
## user exceptions with hierarchy
class AppError(Exception):
    code = 1
    def __init__(self, message, *, hint=None):
        super().__init__(message)
        self.hint = hint
    def __str__(self): return f'[{self.code}] {self.args[0]}' + (f' ({self.hint})' if self.hint else '')
class SizeError(AppError, ValueError): code = 2
class ShapeError(AppError): code = 3

out = []
for cls, kw in ((SizeError, {'hint': 'h'}), (ShapeError, {}), (AppError, {})):
    try:
        raise cls('bad', **kw)
    except ValueError as e: out.append(('V', str(e), e.hint))
    except ShapeError as e: out.append(('S', str(e), repr(e)))
    except AppError as e: out.append(('A', f'{e}', e.code))
return out, issubclass(SizeError, ValueError), [c.__name__ for c in SizeError.__mro__[:3]]
## with and generators
from contextlib import contextmanager
stack = [0]
@contextmanager
def pushed(v):
    stack.append(stack[-1] + v)
    yield stack[-1]
    stack.pop()
def rows():
    for i in range(2):
        with pushed(i + 1) as top:
            with pushed(10) as inner:
                yield top, inner
class Timer:
    def __enter__(self): self.n = 0; return self
    def __exit__(self, *a): self.n = 9

with Timer() as t: t.n = 5
return list(rows()), stack, t.n
## properties that compute
class Circle:
    def __init__(self, r): self.r = r
    @property
    def area(self): return math.pi * self.r ** 2
    @property
    def diameter(self): return self.r * 2
    @diameter.setter
    def diameter(self, d): self.r = d / 2
class Ring(Circle):
    def __init__(self, r, hole): super().__init__(r); self.hole = hole
    @property
    def area(self): return super().area - math.pi * self.hole ** 2
    @Circle.diameter.getter
    def diameter(self): return self.r * 20

c, r = Circle(2), Ring(3, 1)
c.diameter = 10
return c.r, c.area, r.area, r.diameter
## super in many places
class Base:
    tags = ('base',)
    def __init__(self, *a, **k): self.log = ['Base']
    def __repr__(self): return f'<{self.__class__.__name__}>'
    def __eq__(self, o): return type(self) is type(o)
    def __hash__(self): return 1
    @classmethod
    def make(cls, n): return [cls() for _ in range(n)]
    @staticmethod
    def util(x): return x + 1
class A(Base):
    tags = Base.tags + ('a',)
    def __init__(self, *a, **k):
        super().__init__(*a, **k)
        self.log.append('A')
    @classmethod
    def make(cls, n): return super().make(n + 1)
    def __repr__(self): return 'A' + super().__repr__()
    @staticmethod
    def util(x): return Base.util(x) * 2
class B(A):
    def __init__(self): Base.__init__(self); self.log.append('B')
    def each(self): return [super(B, self).util(i) for i in range(2)]

return A().log, B().log, len(B.make(2)), repr(B()), A() == A(), A() == B(), A.tags, B().each(), len({A(), A(), B()})
## static data in classes
class Board:
    SIZE = 3
    DIRS = [(0, 1), (1, 0)]
    LOOK = {d: i for i, d in enumerate(DIRS)}
    NAMES = tuple(f'r{i}' for i in range(3))
    def cells(self): return [(r, c) for r in range(self.SIZE) for c in range(Board.SIZE) if (r + c) % 2]
    if SIZE > 2: BIG = True
    for _i in range(2): LAST = _i
    def helper(x, k=SIZE): return x * k
    TRIPLE = helper(5)

return Board().cells(), Board.LOOK[(1, 0)], Board.NAMES, Board.BIG, Board.LAST, Board.TRIPLE
## arguments that are lambdas
def pipe(v, *fs):
    for f in fs: v = f(v)
    return v
def apply(f, n=1, *a, **k): return [f(*a, **k) for _ in range(n)]
ops = dict(add=lambda a, b: a + b, neg=lambda a: -a, const=lambda: 7, var=lambda *a: len(a), kw=lambda **k: sorted(k))

return pipe(3, lambda x: x + 1, str, lambda s: s * 2, int), apply(lambda: 5, 2), apply(lambda a, b=2: a * b, 1, 4), ops['add'](1, 2), ops['neg'](3), ops['const'](), ops['var'](1, 2), ops['kw'](b=1, a=2), (lambda: (yield 1))and 1, sorted([(2, 'a'), (1, 'b')], key=lambda t: (t[1], t[0])), list(map(lambda p: p[0] + p[1], [(1, 2)])), (lambda x: lambda y: x - y)(5)(3)
## iteration tools of classes
class Grid:
    def __init__(self, w, h): self.w, self.h = w, h
    def __iter__(self):
        for y in range(self.h):
            for x in range(self.w): yield x, y
    def __len__(self): return self.w * self.h
    def __contains__(self, p): return 0 <= p[0] < self.w and 0 <= p[1] < self.h
    def neighbours(self, x, y): yield from (p for p in ((x + 1, y), (x, y + 1), (x - 1, y)) if p in self)

g = Grid(3, 2)
return list(g)[-1], len(g), (2, 1) in g, (3, 0) in g, [list(g.neighbours(*p)) for p in g][:2], dict(zip(g, range(6)))[(1, 1)], max(g, key=sum), sorted(g, reverse=True)[0], bool(Grid(0, 5)), [*zip(*g)][0], sum(x * y for x, y in g)
## walking dictionaries
tree = {'root': {'a': {'x': 1}, 'b': 2}, 'list': [1, {'deep': (2, 3)}]}
def walk(node, path=()):
    match node:
        case dict():
            for k, v in node.items(): yield from walk(v, path + (k,))
        case list() | tuple():
            for i, v in enumerate(node): yield from walk(v, (*path, i))
        case leaf: yield '/'.join(map(str, path)), leaf

flat = dict(walk(tree))
return flat, sorted(flat, key=len)[-1], sum(flat.values()), {k.rsplit('/', 1)[-1]: v for k, v in flat.items()}
## sets of points
pts = {(x, y) for x in range(-2, 3) for y in range(-2, 3) if x * x + y * y <= 4}
edge = {p for p in pts if any((p[0] + dx, p[1] + dy) not in pts for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1)))}

return len(pts), len(edge), sorted(pts - edge), (0, 0) in pts, sorted(edge)[0], max(pts), {abs(x) for x, _ in pts} == {0, 1, 2}
## wave function collapse
TILES = {'g': {'g', 's'}, 's': {'g', 's', 'w'}, 'w': {'s', 'w'}}
def solve(n, seed):
    rng = random.Random(seed)
    options = [set(TILES) for _ in range(n)]
    while any(len(o) > 1 for o in options):
        i = min((len(o), k) for k, o in enumerate(options) if len(o) > 1)[1]
        options[i] = {rng.choice(sorted(options[i]))}
        changed = True
        while changed:
            changed = False
            for a in range(n - 1):
                for p, q in ((a, a + 1), (a + 1, a)):
                    allowed = set().union(*(TILES[t] for t in options[p]))
                    new = options[q] & allowed
                    if new != options[q]: options[q] = new; changed = True
    return ''.join(next(iter(o)) for o in options)

return [solve(8, s) for s in range(4)]
## poisson discs
def discs(w, h, r, seed=1, k=8):
    rng = np.random.default_rng(seed)
    pts = [np.array([w / 2, h / 2])]
    active = [0]
    while active:
        i = active[int(rng.integers(len(active)))]
        for _ in range(k):
            a, d = rng.uniform(0, 2 * np.pi), rng.uniform(r, 2 * r)
            p = pts[i] + d * np.array([np.cos(a), np.sin(a)])
            if (0 <= p).all() and p[0] < w and p[1] < h and min(np.linalg.norm(p - q) for q in pts) >= r:
                pts.append(p)
                active.append(len(pts) - 1)
                break
        else:
            active.remove(i)
    return pts

found = discs(4, 3, 1.2)
return len(found), [p.round(5).tolist() for p in found]
## voronoi by numpy
rng = np.random.default_rng(5)
seeds = rng.random((4, 2)) * 5
yy, xx = np.mgrid[0:5, 0:5]
cells = np.stack([xx, yy], axis=-1).reshape(-1, 2)
d = np.linalg.norm(cells[:, None, :] - seeds[None, :, :], axis=2)
owner = d.argmin(axis=1).reshape(5, 5)
return owner.tolist(), np.bincount(owner.ravel(), minlength=4).tolist(), np.round(d.min(axis=1)[:3], 5).tolist(), [(int(i), float(d[owner.ravel() == i].min().round(4))) for i in np.unique(owner)]
## heights and gradients
x = np.linspace(-2, 2, 5)
X, Y = np.meshgrid(x, x)
Z = np.exp(-(X ** 2 + Y ** 2)) * np.cos(X)
gy, gx = np.gradient(Z)
peak = np.unravel_index(np.argmax(Z), Z.shape)
mask = Z > Z.mean()
return Z.round(5).tolist()[1], gx.round(5)[2].tolist(), [int(v) for v in peak], int(mask.sum()), Z[mask].max(), np.where(mask, Z, 0).sum().round(6), np.clip(Z, .1, .5)[0].tolist(), [(float(a), float(b)) for a, b in zip(X[mask], Y[mask])][:2], (Z / Z.max()).min(), np.percentile(Z, [25, 75]).tolist(), Z[::2, ::-2].shape
## arrays of arrays
a = np.array([(1, 2), (3, 4)], dtype=float)
b = np.asarray(a, dtype=int)
c = np.array([np.arange(3), np.ones(3)])
a[0] = a[1] * 2
a[:, 1] -= 1
d = a
d += 1
for row in c: row *= 2
for i, (p, q) in enumerate(a): a[i] = q, p
total = np.zeros(2)
for v in a: total += v
return a.tolist(), b.tolist(), c.tolist(), d is a, total.tolist(), [tuple(v) for v in a], a[0] @ a[1], (a > 3).any(axis=0).tolist(), sorted(map(tuple, a.tolist())), np.vstack([a, total])[-1].tolist(), list(a.shape), a[..., 0].max(), a.copy()[0, 0]
## splines by numpy
def catmull(P, n=4):
    P = np.asarray(P, float)
    out = []
    for i in range(1, len(P) - 2):
        for t in np.linspace(0, 1, n, endpoint=False):
            T = np.array([1, t, t ** 2, t ** 3])
            M = 0.5 * np.array([[0, 2, 0, 0], [-1, 0, 1, 0], [2, -5, 4, -1], [-1, 3, -3, 1]])
            out.append(T @ M @ P[i - 1:i + 3])
    return np.array(out)

c = catmull([(0, 0), (1, 2), (3, 3), (4, 0), (6, 1)])
seg = np.diff(c, axis=0)
return c.round(5).tolist(), np.hypot(*seg.T).sum().round(6), np.degrees(np.arctan2(seg[:, 1], seg[:, 0])).round(3).tolist()
## rotations by numpy
def rodrigues(axis, a):
    k = np.array(axis, float); k /= np.linalg.norm(k)
    K = np.array([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
    return np.eye(3) + np.sin(a) * K + (1 - np.cos(a)) * K @ K
def look_at(d):
    z = np.array(d) / np.linalg.norm(d)
    x = np.cross([0, 1, 0], z); x = x / np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])

R = rodrigues((1, 1, 0), 0.7)
return (R @ [1, 2, 3]).round(6).tolist(), bool(np.allclose(R.T @ R, np.eye(3))), look_at((1., 0.5, 2.)).round(6).tolist(), np.trace(R).round(6), np.arccos((np.trace(R) - 1) / 2).round(6)
## shapes from objects
from dataclasses import dataclass, field
@dataclass
class Block:
    size: tuple
    color: tuple = (1, 0, 0)
    children: list = field(default_factory=list)
    def build(self):
        own = primitive_call('cube', color=self.color, shape_kwargs={'scale': self.size})
        return concat_shapes(own, *(transform_shape(c.build(), translation_matrix((0, i + 1, 0))) for i, c in enumerate(self.children)))

s = Block((1, 2, 3), children=[Block((1, 1, 1)), Block((2, 2, 2), children=[Block((3, 3, 3))])]).build()
return len(s), [len(transform_shape(s, scale_matrix(2, (0, 0, 0))))]
## shapes in containers
rows = {k: [primitive_call('cube') for _ in range(n)] for k, n in (('a', 2), ('b', 3))}
flat = [s for group in rows.values() for s in group]
whole = concat_shapes(*flat)
named = sorted(rows.items(), key=lambda kv: -len(kv[1]))
total = sum(flat, [])
pairs = list(zip(rows['a'], rows['b']))
return len(whole), named[0][0], len(total), len(pairs), bool(whole), bool([]), len(concat_shapes()), len([*whole, *rows['a'][0]])
## several returns
def f(n):
    if n > 5: return 'big'
    for i in range(n):
        for j in range(n):
            if i * j == 4: return i, j
            if i + j > 6: break
        else:
            continue
        break
    else:
        return 'none'
    try:
        return 'try'
    finally:
        n += 1
def g(items):
    while items:
        x = items.pop()
        if x == 0: continue
        if x < 0: return x
    return

return [f(n) for n in range(7)], g([1, 0, -2, 3]), g([]), g([5])
## shadowed builtins
def list_of(max, min=0): return [max, min]
class pow:
    def __init__(self, v): self.v = v
id = 5
type = 'kind'
input = [1, 2]
len_ = len

max = 7
return list_of(3), pow(4).v, id, type, input, max, len_([1])
## global and nonlocal
count = 0
log = []
def up(n=1):
    global count
    count += n
    log.append(count)
    return count
def outer():
    v = 'o'
    def middle():
        nonlocal v
        v = v + 'm'
        def inner():
            nonlocal v
            v = v + 'i'
        inner()
        return v
    return middle() + v
def makes():
    global made
    made = 42

up(); up(5); makes()
return count, log, outer(), made, up(up())
## mutable class state between calls
class Ids:
    _next = 0
    @classmethod
    def new(cls):
        cls._next += 1
        return cls._next
class Sub(Ids): pass
class Cache(dict):
    hits = 0
    def __getitem__(self, k):
        if k in self: Cache.hits += 1
        else: self[k] = k ** 2
        return super().__getitem__(k)

c = Cache()
return Ids.new(), Ids.new(), Sub.new(), Ids.new(), Sub.new(), [c[3], c[3], c[4]], Cache.hits, dict(c), len(c)
## operators that are reflected
class N:
    def __init__(self, v): self.v = v
    def __radd__(self, o): return ('radd', o)
    def __rsub__(self, o): return ('rsub', o)
    def __rmul__(self, o): return ('rmul', o)
    def __rtruediv__(self, o): return ('rdiv', o)
    def __rpow__(self, o): return ('rpow', o)
    def __lt__(self, o): return ('lt', o)
    def __eq__(self, o): return ('eq', o)
    def __ne__(self, o): return ('ne', o)
    def __and__(self, o): return ('and', o)
    def __ror__(self, o): return ('ror', o)
    def __contains__(self, o): return o > 5
    def __rmatmul__(self, o): return ('rmat', o)
    def __divmod__(self, o): return ('dm', o)
    def __index__(self): return 2
    def __float__(self): return 2.5
    def __int__(self): return 9
    def __complex__(self): return 1j

n = N(1)
return 1 + n, 2 - n, 'a' * n, 3 / n, 2 ** n, 5 > n, n < 4, n == 1, 1 != n, n & 2, 3 | n, 7 in n, 2 in n, [0] @ n, divmod(n, 3), [5, 6, 7][n], float(n), int(n), [0, 1, 2, 3][n:], list(range(n)), math.sqrt(n), hex(n), 'abc'[n], 1.5 + n, (1,) + n
## comparisons of containers
from collections import OrderedDict, deque
return [1, 2] == [1, 2], (1, 2) < (1, 2, 0), [1, [2]] == [1, [2]], {'a': 1} == {'a': 1.0}, {1, 2} == frozenset([2, 1]), 'ab' < 'b', [] < [0], (1, 'a') < (1, 'b'), [1, 2] != (1, 2), {1} < {1, 2}, not {3} < {1, 2}, None == 0, deque([1]) == deque([1]), range(0) == range(5, 5), (1, (2, 3)) == (1, (2, 3)), [None] == [None], {'x': [1]} != {'x': [2]}, max([[1, 2], [1, 3]]), min('b', 'a'), sorted([(2, 1), (1, 2), (1, 1)]), [1] in [[1]], () == tuple(), 1 in {1: 2}, True in [1]
## loops with else and nested breaks
found = []
for n in range(2, 20):
    for d in range(2, n):
        if n % d == 0: break
    else: found.append(n)
i = 0
while i < 10:
    i += 1
    if i % 2: continue
    for j in range(i):
        if j > 3: break
    else:
        found.append(('full', i))
        continue
    found.append(('cut', i))
    if i > 6: break
else:
    found.append('never')
return found, i, j, n, d
## numbers as text tables
rows = [('oak', 3.14159, 2), ('pine', 10.5, 11)]
lines = [f'{n:<6}|{v:>8.2f}|{k:03d}' for n, v, k in rows]
head = f"{'name':^6}|{'value':>8}|{'k':>3}"
return lines, head, '-' * len(head), '\n'.join([head, *lines]).count('|'), f'{rows[1][1]:.1e}', f'{rows!r:.10}', f'{len(rows)=}', f'{rows[0][0]!r:>8}', f"{'x':{'>'}{4}}", f'{1e6:,.0f}', f'{255:08b}', f'{-5:+}', f'{0.5:.0%}', f'{3:e}', f'{1234567.891:_.1f}', f'{"a":>3}{"b":<3}|'
## a generator that sees what changes

n = 1
g = (n * i for i in range(3))
n = 10
return [x for x in g]
## index or not
xs = [4, 8, 15]
def place(v):
    try: return xs.index(v)
    except ValueError: return -1

return place(8), place(9), xs.index(4), 'abc'.index('c'), 'abc'.find('z')
## set operators and updates
a = {1, 2, 3}
b = a
b |= {9}
c = {x: y for x, y in zip('ab', (1, 2))}
c |= {'z': 3}

return sorted(a), c, sorted(a - {1}), sorted({1} ^ a), a > {1}, sorted({3, 1} | {2})
## protocols of numbers
class Deg:
    def __init__(self, d): self.d = d
    def __float__(self): return math.radians(self.d)
    def __int__(self): return int(self.d)
    def __round__(self, n=None): return Deg(round(self.d, n) if n else round(self.d))
    def __abs__(self): return Deg(abs(self.d))
    def __neg__(self): return Deg(-self.d)
    def __trunc__(self): return 1
    def __floor__(self): return 2
    def __ceil__(self): return 3
    def __bool__(self): return self.d != 0

d = Deg(-90.6)
return float(d), int(d), round(d).d, abs(d).d, (-d).d, math.floor(d), math.ceil(d), math.sin(Deg(30)), bool(Deg(0)), 5 if Deg(0) else 6, not Deg(1)
## memo by hand
def memo(f):
    known = {}
    def inner(*a):
        if a not in known: known[a] = f(*a)
        return known[a]
    inner.known = known
    return inner
@memo
def paths(x, y): return 1 if 0 in (x, y) else paths(x - 1, y) + paths(x, y - 1)

return paths(6, 6), len(paths.known)
## chained decorators with arguments
from functools import wraps
def repeat(n=2, *, join=sum):
    def deco(f):
        @wraps(f)
        def inner(*a, **k): return join([f(*a, **k) for _ in range(n)])
        return inner
    return deco
class Tag:
    def __init__(self, name): self.name = name
    def __call__(self, f):
        f.tag = self.name
        return f
@repeat(3)
@repeat(join=max)
def f(x, y=1): return x * y
@Tag('t')
def g(): return 1

return f(2, y=5), f.__name__, g.tag, g()
## methods that return generators
class Path:
    def __init__(self, *pts): self.pts = pts
    def segments(self): return zip(self.pts, self.pts[1:])
    def lengths(self): yield from (math.dist(a, b) for a, b in self.segments())
    def sample(self, n):
        for (ax, ay), (bx, by) in self.segments():
            for i in range(n): yield ax + (bx - ax) * i / n, ay + (by - ay) * i / n
        yield self.pts[-1]

p = Path((0, 0), (3, 4), (3, 0))
return list(p.lengths()), sum(p.lengths()), list(p.sample(2)), max(p.segments())
## events and queues
import heapq
from collections import deque
from itertools import count
class Sim:
    def __init__(self): self.now, self.queue, self.ids, self.log = 0, [], count(), []
    def at(self, t, f, *a): heapq.heappush(self.queue, (t, next(self.ids), f, a))
    def run(self):
        while self.queue:
            self.now, _, f, a = heapq.heappop(self.queue)
            f(*a)
        return self.log
    def drop(self, name, n):
        self.log.append((self.now, name))
        if n: self.at(self.now + 2, self.drop, name, n - 1)

s = Sim()
s.at(1, s.drop, 'a', 2)
s.at(0.5, s.drop, 'b', 1)
d = deque([1, 2, 3])
d.rotate(-1)
return s.run(), list(d)
## permutations and backtracking
def queens(n, placed=()):
    if len(placed) == n:
        yield placed
        return
    for c in range(n):
        if all(c != p and abs(c - p) != len(placed) - i for i, p in enumerate(placed)): yield from queens(n, placed + (c,))
def subsets(s): return [[]] if not s else (lambda r: r + [[s[0], *x] for x in r])(subsets(s[1:]))

return list(queens(5))[:2], sum(1 for _ in queens(6)), subsets([1, 2, 3])
## grammars of shapes
import random
RULES = {'house': [['base', 'roof'], ['base', 'floor', 'roof']], 'base': ['box'], 'floor': [['box', 'box']]}
def expand(symbol, rng, depth=0):
    options = RULES.get(symbol)
    if options is None or depth > 5: return [symbol]
    match rng.choice(options):
        case str() as one: return expand(one, rng, depth + 1)
        case [*many]: return [t for each in many for t in expand(each, rng, depth + 1)]

return [expand('house', random.Random(s)) for s in range(4)]
## clamps and ranges
def clamp(v, lo=0, hi=1): return max(lo, min(hi, v))
def frange(a, b, step):
    while a < b - 1e-9:
        yield round(a, 10)
        a += step
def remap(v, a, b, c=0, d=1): return c + (v - a) / (b - a) * (d - c)

return clamp(5), clamp(-2, hi=3), list(frange(0, 1, .25)), remap(5, 0, 10), remap(2, 0, 4, 10, 20), [*range(10, 0, -3)], list(range(3))[::-1], sum(range(101))
## texts as patterns
ROWS = ['X.X', '.O.', 'X.X']
KEY = str.maketrans({'X': '1', 'O': '2', '.': '0'})

grid = [[int(c) for c in row.translate(KEY)] for row in ROWS]
turned = [list(r) for r in zip(*grid[::-1])]
return grid, turned, ''.join(ROWS).count('X'), [r.index('X') if 'X' in r else -1 for r in ROWS], ['{:>5}|'.format(r) for r in ROWS], '\n'.join(ROWS).splitlines() == ROWS, [ROWS[i][j] for i, j in ((0, 0), (1, 1))], ' '.join(reversed(ROWS))
## arrays of objects
class Cell:
    def __init__(self, v): self.v = v
    def __add__(self, o): return Cell(self.v + (o.v if isinstance(o, Cell) else o))
    __radd__ = __add__
    def __lt__(self, o): return self.v < o.v
a = np.array([[Cell(i + j) for j in range(2)] for i in range(2)], dtype=object)

return a.shape, a[1, 1].v, (a + 1)[0, 0].v, [c.v for c in a.ravel()], sum(a.flatten()).v, max(a.ravel()).v
## cumulative and windows by numpy
a = np.array([3, 1, 4, 1, 5, 9, 2, 6])
w = np.lib.stride_tricks.sliding_window_view(a, 3) if False else np.array([a[i:i + 3] for i in range(len(a) - 2)])

return w.sum(axis=1).tolist(), np.cumsum(a).tolist(), np.cumprod(a[:4]).tolist(), np.maximum.accumulate(a).tolist(), np.diff(a, n=2).tolist(), np.convolve(a, np.ones(3) / 3, mode='valid').round(4).tolist(), np.trapz(a) if hasattr(np, 'trapz') else 1, a[::-1].cumsum()[::-1].tolist(), np.argsort(-a, kind='stable').tolist(), np.flatnonzero(np.diff(np.sign(np.diff(a)))).tolist()
## dates and names of things
from enum import Enum
class Season(Enum):
    SPRING, SUMMER, AUTUMN, WINTER = range(4)
    def next(self): return Season((self.value + 1) % 4)
    @classmethod
    def parse(cls, text): return cls[text.upper()]
    @property
    def warm(self): return self in {Season.SPRING, Season.SUMMER}

return Season.WINTER.next().name, Season.parse('summer').warm, Season.AUTUMN.warm, [s.next().value for s in Season], {s: s.name.lower() for s in Season}[Season.SPRING], Season(2).name, len(Season)
## sums of vectors
V = tuple[float, float, float]
def add(*vs): return tuple(map(sum, zip(*vs)))
def scale(v, k): return tuple(c * k for c in v)
def dot(a, b): return sum(x * y for x, y in zip(a, b, strict=True))
def cross(a, b): return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
def unit(v): return scale(v, 1 / math.sqrt(dot(v, v)))

return add((1, 2, 3), (4, 5, 6), (0, 0, 1)), scale((1, 2), 3), dot((1, 2, 3), (4, 5, 6)), cross((1, 0, 0), (0, 1, 0)), unit((3, 4, 0))
## objects that are functions of time
class Track:
    def __init__(self, **keys): self.keys = sorted((float(k[1:]), v) for k, v in keys.items())
    def __call__(self, t):
        for (a, va), (b, vb) in zip(self.keys, self.keys[1:]):
            if a <= t <= b: return va + (vb - va) * (t - a) / (b - a)
        return self.keys[-1][1] if t > self.keys[-1][0] else self.keys[0][1]
    def __mul__(self, k): return Track(**{f't{int(t)}': v * k for t, v in self.keys})

track = Track(t0=0, t2=10, t4=5) * 2
return [track(t) for t in (-1, 0, 1, 3, 4, 9)]
## mixins before a base with a hook
made = []
class A:
    def __init_subclass__(cls, **named): made.append((cls.__name__, *named.values()))
class Mixin: pass
class B(Mixin, A): pass
class C(B, k=2): pass

return made
## enumerations of texts
from enum import Enum, auto
class S(str, Enum):
    A = auto()
    B = 'x'
    C = auto()
    def __str__(self): return 'S!' + self.value
class T(str, Enum):
    A = auto()
    B = 'x'

return S.A.value, repr(S.A), str(S.A), f'{S.A}', format(S.A, '>8'), '%s' % S.B, S.C.value, repr(T.A), str(T.A), f'{T.B:>8}', T.B.upper(), T('x').name, S.B == 'x', '{}'.format(S.B)
## enumerations of numbers and flags as texts
from enum import Enum, Flag, IntEnum, IntFlag
class F(IntFlag):
    A = 1
    B = 2
class G(Flag):
    A = 1
    B = 2
class I(int, Enum):
    A = 1
    def __str__(self): return 'I!'
class J(IntEnum): A = 1
class K(int, Enum): A = 1

return str(F.A), str(F.A | F.B), f'{F.A}', repr(F.A | F.B), str(F(0)), repr(F(0)), str(G.A), str(G.A | G.B), f'{G.A}', repr(G.A | G.B), str(G(0)), repr(G(0)), str(I.A), f'{I.A}', f'{I.A:>4}', str(J.A), f'{J.A:>3}', repr(J.A), str(K.A), f'{K.A}', K.A + 1
## patterns with alternatives
import re
class A: pass
class B(A): pass

b = B()
return [m.group() for m in re.finditer(r'(ab|cd)?x|\d+(?:\.\d+)?|(?:[a-z]\d)+', 'abx 1.5 a1b2 7')], re.split(r'[,;]\s*', 'a, b;c'), bool(re.match(r'(a|b)*c', 'abac'))
## objects that give iterators
import itertools
class Q:
    def __iter__(self): return iter([1, 2, 3])
class R:
    def __iter__(self): return itertools.chain([1], [2])

i = iter(Q())
return sum(Q()), max(Q()), list(R()), next(i), [*i], list(zip(Q(), R())), 2 in Q()
## shapes in place by another name
def both():
    s = concat_shapes(primitive_call('cube'), primitive_call('sphere'))
    w = s
    w += primitive_call('sphere')
    return s

return [len(both())]
## shapes of the caller in place
def grow(shape): shape += primitive_call('cube')

kept = primitive_call('cube')
moved = transform_shape(kept, translation_matrix((1, 2, 3)))
whole = concat_shapes(kept, kept)
grow(kept)
grow(kept)
later = concat_shapes(kept, kept)
return [len(kept), len(moved), len(whole), len(later)]
## shapes in place in a list
parts = []
one = primitive_call('cube')
parts.append(one)
one += primitive_call('sphere')
return [len(parts[0])]
## copies of shapes keep their parts
one = primitive_call('cube')
two = one.copy()
two += primitive_call('sphere')
three = list(one)
three += one
return [len(one), len(two), len(three)]
## copies of shapes that are evaluated
class A: pass
class B(A): pass

b = B()
one = primitive_call('cube')
two = one.copy()
two += primitive_call('sphere')
one.extend(two)
three = list(one)
three += one
return [len(one), len(two), len(three)]
## generators that are named in a test
if (g := (x for x in range(2))): pass
return [*g, *g]
## generators as items
l = []
l.append(x for x in range(3))
return [*l[0], *l[0]]
'''
# Programs that the translation proper would take, were it not for what they do in place, late or by identity.
NUMBERS = """from helper import *
import math, random
import numpy as np
{top}

def values():
{body}

@register()
def scene() -> Shape:
    return concat_shapes(*[
        transform_shape(primitive_call('cube'), translation_matrix((k, x + 0, 0))) for k, x in enumerate(values())
    ])
"""
PLAIN_TEXT = r"""
## finally after return
log = []
def deep(n):
    log.append(n)
    try:
        if n > 2: return n
        return deep(n + 1) * 2
    finally:
        log.append(-n)

out = deep(0)
for i in range(5):
    try:
        if i == 1: continue
        if i == 3: break
        log.append(10 * i)
    finally: log.append(.5)
return [out, *log]
## finally with a counter
depth = 0
def walk(n):
    global depth
    depth += 1
    try:
        return depth + (walk(n - 1) if n else 0)
    finally:
        depth -= 1

return [walk(3), walk(2), depth]
## finally before an exception goes on
log = []
def part():
    try: log.append([1, 2][5])
    finally: log.append(7)

try: part()
except IndexError: log.append(8)
return log
## sets in place by another name
w = {1, 2, 3}
u = w
u -= {3}
return [len(w), len(u)]
## tables in place by another name
t = {1: 2}
s = t
s |= {5: 6}
return [len(t)]
## sets of the caller in place
def add_all(seen, xs): seen |= set(xs)

mine = {1}
add_all(mine, [4, 5])
return [len(mine)]
## sets in place in a table
d = {'a': {1}}
e = d['a']
d['a'] |= {2, 3}
return [len(e)]
## sets in place alone
seen = set()
for i in range(4): seen |= {i, i + 1}
rest = set(range(10))
rest -= seen
rest &= {5, 6, 7}
return [len(seen), len(rest)]
## shapes in place alone
one = primitive_call('cube')
for i in range(3): one += primitive_call('sphere')
return [len(one)]
## generators that draw
legs = (random.random() for x in range(3))
first = random.random()
return [first, *legs]
## generators used twice
legs = (2 * x for x in range(3))
return [*legs, *legs]
## generators bind late
k = 1
g = (k * x for x in range(3))
k = 10
return list(g)
## iterators see changes
lst = [1, 2]
m = map(lambda x: x + 1, lst)
lst.append(3)
return list(m)
## generators are exhausted
g = (x for x in range(6))
a = 3 in g
return [a, *g]
## generators are exhausted by tests
h = (x > 2 for x in range(6))
a = any(h)
return [a, len(list(h))]
## maps are exhausted
m = map(lambda x: -x, [3, 1, 2])
a = max(m)
return [a, *m]
## other iterators are exhausted
z = zip([1, 2, 3], [4, 5, 6])
a = len(list(z)), len(list(z))
r = reversed([1, 2, 3])
o = [x for x in r if x > 1], list(r)
n = enumerate([5, 6])
return [*a, *o[0], *o[1], len(list(n)), len(list(n))]
## filters in a loop
f = filter(None, [1, 2, 3])
found = []
for i in range(2):
    for x in f: found.append(x)
return found
## generators as arguments
def twice(parts): return [*parts, *parts]

return twice(x for x in range(3))
## generators that are returned
def make(): return (x * x for x in range(3))

g = make()
return [*g, *g, 7]
## generators of fields
class Bag:
    def __init__(self, items): self.items = items

b = Bag(x for x in range(3))
return [*b.items, *b.items]
## generators beside other draws
return [x + random.random() for x in (random.random() for _ in range(3))]
## loops over generators beside other draws
b = []
for x in (random.random() for _ in range(3)): b.append(x + random.random())
return b
## generators beside each other
return [x - y for x, y in zip((random.random() for _ in range(2)), (random.random() for _ in range(2)))]
## generators once
legs = (random.random() for x in range(3))
found = [*legs, 4]
pairs = zip([1, 2], [3, 4])
for a, b in pairs: found.append(a * b)
return [*found, sum(x for x in range(4)), max(map(abs, [-1, -2]))]
## views of tables
d = {'a': 1}
ks = d.keys()
d['b'] = 2
return [len(ks)]
## values of tables
d = {'a': 1}
ks = d.values()
d['b'] = 2
return [*ks]
## frozensets as items
links = set()
links.add(frozenset((1, 2)))
links.add(frozenset((2, 1)))
return [len(links)]
## frozensets as keys
d = {frozenset((1, 2)): 5}
return [d[frozenset((2, 1))]]
## frozensets in comprehensions
pairs = [frozenset((1, 2))]
key = frozenset((2, 1))
return [key in pairs, len({frozenset(p) for p in [(1, 2), (2, 1)]})]
## frozensets as constants
WOODS = frozenset(['oak', 'ash'])

return [int('oak' in WOODS), int('fir' in WOODS), len(WOODS)]
## instances are not equal
class Cell:
    def __init__(self, x): self.x = x

a, b = Cell(1), Cell(1)
return [a == b, a != b, a == a]
## instances in lists
class Cell:
    def __init__(self, x): self.x = x

a, b = Cell(1), Cell(1)
return [a in [b], a in [b, a]]
## instances are removed
class Cell:
    def __init__(self, x): self.x = x

a, b = Cell(1), Cell(1)
b.x = 2
a.x = 2
cells = [b, a]
cells.remove(a)
cells[0].x = 9
return [b.x, a.x, len(cells)]
## instances are counted
class Cell:
    def __init__(self, x): self.x = x

a, b = Cell(1), Cell(1)
return [[b, a].index(a), [a, b].count(a)]
## instances in tuples and sets
class Cell:
    def __init__(self, x): self.x = x

a, b = Cell(1), Cell(1)
return [(a, 1) == (b, 1), len({a, b})]
## instances as keys
class Cell:
    def __init__(self, x): self.x = x

a, b = Cell(1), Cell(1)
d = {}
d[a] = 1
d[b] = 2
return [len(d)]
## instances are the same
from dataclasses import dataclass
@dataclass
class P:
    x: int

a, b = P(1), P(1)
return [a is b, a is a, a == b]
## columns of matrices in place
m = np.eye(4)
t = m[:3, 3]
t += [1, .5, 0]
return [m[0, 3], m[1, 3]]
## columns of arrays in place
n = np.arange(9.).reshape(3, 3)
col = n[:, 0]
col *= 3
return [n[i, 0] for i in range(3)]
## items of rows
n = np.arange(9.).reshape(3, 3)
row = n[1]
row[2] = 5
return [n[1, 2]]
## rows in loops
P = np.ones((2, 3))
for p in P: p += 1
return [P[0, 0], P[1, 2]]
## rows of arrays in place
V = np.zeros((4, 3))
for i in range(4): V[i] += [1, i, 0]
W = np.array([[1., 2], [3, 4]])
W[1] *= 2
W[0] -= W[1]
return [*V.ravel(), *W.ravel()]
## items of arrays by name
v = np.array([1., 2, 3])
x = v[0]
x += 5
for y in v: y += 1
row = np.array([[1., 2], [3, 4]])[1]
return [x, v[0], row[0]]
## keys that are equal numbers
d = {1: 'a', 1.0: 'b', True: 'c'}
return [len(d)]
## counts of equal numbers
return [[1, True, 1.0].count(1), [1, 1.0].count(1), [0, 1.0].index(1), len({0, False, 0.0})]
## items that are equal numbers
return [{1: 5}[1.0], int(1.0 in [1]), {2: 3}.get(2.0, 0), int(1 in {1.0, 2.0}), int([1, 2.0] == [1.0, 2]), len({1, 1.0})]
## Booleans as items
return [True in [1], 1 in [True], [True, False].count(True)]
## keys of two kinds
d = {}
for k in (1, 1.0, 2): d[k] = k
e = {1: 2}
e[True] = 5
return [len(d), len(e)]
## rows in place
n = np.arange(9.).reshape(3, 3)
row = n[1]
row += 5
z = np.zeros((2, 2))
r = z[0]
r += 3
return [*n[1], *z[0]]
## changes seen by a view
n = np.array([[1., 2], [3, 4]])
row = n[1]
n[1, 0] = 9
return [*row]
"""


def features() -> dict[str, str]:
    """The programs by name."""
    return _programs(TEXT, FRAME) | _programs(PLAIN_TEXT, NUMBERS)


def _programs(text: str, frame: str) -> dict[str, str]:
    found = {}
    for part in text.split("\n## ")[1:]:
        name, _, code = part.partition("\n")
        top, _, body = code.rpartition("\n\n")
        lines = "\n".join(f"    {line}" if line else "" for line in body.strip().splitlines())
        future, rest = "", top
        if top.startswith("from __future__"):
            future, _, rest = top.partition("\n")
        found[name] = (f"{future}\n" if future else "") + frame.format(top=rest, body=lines)
    return found
