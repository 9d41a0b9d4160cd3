"""Functions and classes of Python's library in Python, which are translated as those of the program are.

Iterators become lists, which is the same where they are used up.
"""

from __future__ import annotations

import ast

# Functions of the library in Python, by their modules.
_SOURCES = {
    "itertools": """
def pairwise(items):
    rest = list(items)
    return list(zip(rest, rest[1:]))
def starmap(function, rows):
    return [function(*row) for row in rows]
def takewhile(predicate, items):
    taken = []
    for item in items:
        if not predicate(item):
            break
        taken.append(item)
    return taken
def counted_while(predicate, start=0, step=1):
    taken = []
    item = start
    while predicate(item):
        taken.append(item)
        item = item + step
    return taken
def mapped_while(predicate, value, start=0, step=1):
    taken = []
    item = start
    while predicate(value(item)):
        taken.append(value(item))
        item = item + step
    return taken
def first_of_cycle(items, start, stop=None):
    row = list(items)
    first, last = (0, start) if stop is None else (start, stop)
    return [row[i % len(row)] for i in range(first, last)] if row else []
def dropwhile(predicate, items):
    rest = list(items)
    start = 0
    while start < len(rest) and predicate(rest[start]):
        start += 1
    return rest[start:]
def groupby(items, key=None):
    groups = []
    for item in items:
        name = item if key is None else key(item)
        if groups and groups[-1][0] == name:
            groups[-1][1].append(item)
        else:
            groups.append((name, [item]))
    return groups
def compress(items, selectors):
    return [item for item, is_selected in zip(items, selectors) if is_selected]
def zip_longest(*rows, fillvalue=None):
    lists = [list(row) for row in rows]
    size = max([len(row) for row in lists]) if lists else 0
    return [tuple([row[n] if n < len(row) else fillvalue for row in lists]) for n in range(size)]
""",
    "numpy": """
def fill_diagonal(a, val):
    for i in range(min(a.shape)):
        a[i, i] = val
""",
    "string": """
def capwords(s):
    return " ".join([word[:1].upper() + word[1:].lower() for word in s.split()])
""",
    "operator": """
def or_(a, b):
    return a | b
def and_(a, b):
    return a & b
def xor(a, b):
    return a ^ b
def add(a, b):
    return a + b
def mul(a, b):
    return a * b
def matmul(a, b):
    return a @ b
def sub(a, b):
    return a - b
def lt(a, b):
    return a < b
def gt(a, b):
    return a > b
def truediv(a, b):
    return a / b
def neg(a):
    return -a
""",
    "math": """
def log1p(x):
    return math.log(1 + x)
""",
    "bisect": """
def bisect_left(items, x):
    low, high = 0, len(items)
    while low < high:
        middle = (low + high) // 2
        if items[middle] < x:
            low = middle + 1
        else:
            high = middle
    return low
def bisect_right(items, x):
    low, high = 0, len(items)
    while low < high:
        middle = (low + high) // 2
        if x < items[middle]:
            high = middle
        else:
            low = middle + 1
    return low
def insort(items, x):
    low, high = 0, len(items)
    while low < high:
        middle = (low + high) // 2
        if x < items[middle]:
            high = middle
        else:
            low = middle + 1
    items.insert(low, x)
""",
    "heapq": """
def heappush(heap, item):
    place = len(heap)
    heap.append(item)
    while place > 0 and item < heap[(place - 1) // 2]:
        heap[place] = heap[(place - 1) // 2]
        place = (place - 1) // 2
    heap[place] = item
def heappop(heap):
    last = heap.pop()
    if len(heap) == 0:
        return last
    first = heap[0]
    place = 0
    child = 1
    while child < len(heap):
        if child + 1 < len(heap) and not heap[child] < heap[child + 1]:
            child += 1
        heap[place] = heap[child]
        place = child
        child = 2 * place + 1
    while place > 0 and last < heap[(place - 1) // 2]:
        heap[place] = heap[(place - 1) // 2]
        place = (place - 1) // 2
    heap[place] = last
    return first
def nsmallest(n, items):
    return sorted(items)[:n]
def nlargest(n, items):
    return sorted(items, reverse=True)[:n]
""",
    "statistics": """
def pvariance(values):
    middle = sum(values) / len(values)
    return sum((value - middle) ** 2 for value in values) / len(values)
def pstdev(values):
    middle = sum(values) / len(values)
    return math.sqrt(sum((value - middle) ** 2 for value in values) / len(values))
def fmean(values):
    return sum(values) / len(values)
def mean(values):
    return sum(values) / len(values)
def median(values):
    ordered = sorted(values)
    n = len(ordered)
    return ordered[n // 2] if n % 2 else (ordered[n // 2 - 1] + ordered[n // 2]) / 2
""",
}
LIBRARY = {
    f"{module}.{function.name}": ast.unparse(function)
    for module, source in _SOURCES.items()
    for function in ast.parse(source).body
    if isinstance(function, ast.FunctionDef)
}
LIBRARY["collections.Counter"] = """
def Counter(items=()):
    counts = collections.defaultdict(int)
    if isinstance(items, dict):
        for item, number in dict(items).items():
            counts[item] += number
    else:
        for item in items:
            counts[item] += 1
    return counts
"""
# Methods that only texts and counters have, by their names and numbers of arguments.
OWN_METHODS = {
    ("partition", 1): """
def partition(text, separator):
    place = text.find(separator)
    if place < 0:
        return (text, "", "")
    return (text[:place], separator, text[place + len(separator):])
""",
    ("removeprefix", 1): """
def removeprefix(text, prefix):
    return text[len(prefix):] if text.startswith(prefix) else text
""",
    ("removesuffix", 1): """
def removesuffix(text, suffix):
    return text[:len(text) - len(suffix)] if text.endswith(suffix) else text
""",
    ("rpartition", 1): """
def rpartition(text, separator):
    place = text.rfind(separator)
    if place < 0:
        return ("", "", text)
    return (text[:place], separator, text[place + len(separator):])
""",
    ("most_common", 0): """
def most_common(counts):
    return sorted(counts.items(), key=lambda pair: -pair[1])
""",
    ("most_common", 1): """
def most_common_few(counts, n):
    return sorted(counts.items(), key=lambda pair: -pair[1])[:n]
""",
}
LIBRARY["bisect.insort_right"] = LIBRARY["bisect.insort"].replace("def insort", "def insort_right")
# Functions that use up what they are given at once, so that it may be a list.
EAGER = ("Counter", "zip_longest", "fmean", "mean", "median", "pstdev", "pvariance", "nsmallest", "nlargest")
GETTERS = ("operator.attrgetter", "operator.itemgetter", "operator.methodcaller")
LIBRARY["bisect.bisect"] = LIBRARY["bisect.bisect_right"].replace("bisect_right", "bisect")
COUNTER_METHODS = {
    "update": """
def counter_update(counts, items=()):
    if isinstance(items, dict):
        for item, number in dict(items).items():
            counts[item] += number
    else:
        for item in items:
            counts[item] += 1
""",
    "subtract": """
def counter_subtract(counts, items=()):
    if isinstance(items, dict):
        for item, number in dict(items).items():
            counts[item] -= number
    else:
        for item in items:
            counts[item] -= 1
""",
    "elements": """
def counter_elements(counts):
    return [item for item, number in counts.items() for _ in range(number)]
""",
    "total": """
def counter_total(counts):
    return sum(counts.values())
""",
}  # methods of counters that dictionaries do not have, or others

# A `frozenset` that is an item or a key: its members in order, so that equal ones are equal tuples.
FROZEN_SET = """
@dataclass(frozen=True)
class FrozenSet:
    members: tuple
    def __or__(self, other):
        return frozen_set(sorted([*self.members, *other]))
    def __and__(self, other):
        return frozen_set([each for each in self.members if each in other])
    def __sub__(self, other):
        return frozen_set([each for each in self.members if each not in other])
    def __contains__(self, item):
        return item in self.members
    def __len__(self):
        return len(self.members)
    def in_any_order(self):
        return self.members
def frozen_set(items=()):
    return FrozenSet(tuple(sorted(set(items))))
"""

COMPLEX = """
@dataclass(frozen=True)
class complex_number:
    real: float
    imag: float = 0.0
    def __add__(self, other):
        return complex_number(self.real + real_part(other), self.imag + imaginary_part(other))
    def __radd__(self, other):
        return self + other
    def __sub__(self, other):
        return complex_number(self.real - real_part(other), self.imag - imaginary_part(other))
    def __rsub__(self, other):
        return -self + other
    def __mul__(self, other):
        x, y = real_part(other), imaginary_part(other)
        return complex_number(self.real * x - self.imag * y, self.real * y + self.imag * x)
    def __rmul__(self, other):
        return self * other
    def __truediv__(self, other):
        x, y = real_part(other), imaginary_part(other)
        size = x * x + y * y
        return complex_number((self.real * x + self.imag * y) / size, (self.imag * x - self.real * y) / size)
    def __neg__(self):
        return complex_number(-self.real, -self.imag)
    def __abs__(self):
        return math.hypot(self.real, self.imag)
    def conjugate(self):
        return complex_number(self.real, -self.imag)
    def __pow__(self, exponent):
        result = complex_number(1.0, 0.0)
        for _ in range(abs(exponent)):
            result = result * self
        return result if exponent >= 0 else complex_number(1.0, 0.0) / result
def real_part(z):
    return z.real if isinstance(z, complex_number) else z
def imaginary_part(z):
    return z.imag if isinstance(z, complex_number) else 0.0
def complex_rect(radius, angle):
    return complex_number(radius * math.cos(angle), radius * math.sin(angle))
def complex_phase(z):
    return math.atan2(imaginary_part(z), real_part(z))
def complex_polar(z):
    return (math.hypot(real_part(z), imaginary_part(z)), complex_phase(z))
def complex_exp(z):
    return complex_rect(math.exp(real_part(z)), imaginary_part(z))
def complex_sqrt(z):
    return complex_rect(math.sqrt(math.hypot(real_part(z), imaginary_part(z))), complex_phase(z) / 2)
"""

# Iterators from which the program takes items one by one, by `next`.
ITERATORS = {
    "iter": """
class ListIterator:
    def __init__(self, items):
        self.items = items
        self.place = 0
    def has_next(self):
        return self.place < len(self.items)
    def following(self):
        if self.place >= len(self.items):
            raise ValueError("StopIteration")
        self.place += 1
        return self.items[self.place - 1]
    def following_or(self, default):
        return self.following() if self.has_next() else default
    def rest(self):
        first = self.place
        self.place = len(self.items)
        return self.items[first:]
""",
    "itertools.count": """
class CountIterator:
    def __init__(self, start=0, step=1):
        self.value = start
        self.step = step
    def following(self):
        found = self.value
        self.value = found + self.step
        return found
""",
    "itertools.cycle": """
class CycleIterator:
    def __init__(self, items):
        self.items = items
        self.place = 0
    def following(self):
        self.place += 1
        return self.items[(self.place - 1) % len(self.items)]
""",
}
