"""Valid Python that was once refused with an untrue reason, and what a refusal says: where and why evaluation ends."""

from __future__ import annotations

import contextlib
import io

import pytest

from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import Diagnostic
from scenelang.session.session import Session
from transpile.cases import first_difference, flattened, told
from transpile.reference_model import flatten

SESSION = Session()
HEAD = """from helper import *
import itertools, math, time
import numpy as np
from collections import deque

def bar(x, y=0.0, size=1.0):
    return transform_shape(primitive_call('cube', shape_kwargs={'scale': size}), translation_matrix((x, y, 0)))

"""


def program(before: str, body: str) -> str:
    lines = "\n".join(f"    {line}" for line in body.strip("\n").split("\n"))
    return f"{HEAD}{before}\n\n@register()\ndef scene() -> Shape:\n    parts = []\n{lines}\n    return concat_shapes(*parts)\n"


def error_of(code: str) -> Diagnostic:
    (problem,) = [d for d in SESSION.transpile(Source("refused.py", code)).diagnostics if d.is_error]
    return problem


COUNTER = "def numbers():\n    n = 0\n    while True:\n        yield n\n        n += 1"
VALID = {
    "a cycle that is zipped by name": (
        "", "colors = itertools.cycle([1, 2])\nfor i, c in zip(range(5), colors): parts.append(bar(i, c))"
    ),
    "the first of a cycle": (
        "", "for i, c in enumerate(itertools.islice(itertools.cycle([1, 2]), 5)): parts.append(bar(i, c))"
    ),
    "a cycle that is kept": (
        "class Colors:\n    def __init__(self): self.all = itertools.cycle([1, 2])",
        "k = Colors()\nparts.extend(bar(3 * i, next(k.all)) for i in range(5))"
    ),
    "a date with another hour": (
        "from datetime import datetime\nD = datetime(2020, 5, 6, 7).replace(hour=3)", "parts.append(bar(D.hour))"
    ),
    "the bytes of an array": ("", "for i, b in enumerate({np.eye(2).tobytes(), np.eye(2).tobytes()}): parts.append(bar(i))"),
    "an axis of np.roll": ("", "for row in np.roll(np.arange(6.0).reshape(2, 3), 1, axis=0):\n    parts.append(bar(row[0], row[1]))"),
    "keepdims": ("", "for x in np.linalg.norm(np.ones((2, 3)), axis=1, keepdims=True):\n    parts.append(bar(float(x[0])))"),
    "two attributes in one statement": ("class Flock:\n    A, B = 1, 2", "parts.append(bar(Flock.A, Flock.B))"),
    "a method that is assigned later": (
        "class Box:\n    def __init__(self, x):\n        self.x = x\ndef place(self):\n    return bar(self.x)\nBox.place = place",
        "parts.append(Box(2).place())",
    ),
    "maxlen": ("", "d = deque(maxlen=3)\nfor i in range(5):\n    d.append(i)\nparts += [bar(x) for x in d]"),
    "break out of an endless generator": (COUNTER, "for x in numbers():\n    if x > 4:\n        break\n    parts.append(bar(x))"),
    "next of an endless generator": (COUNTER, "g = numbers()\nnext(g)\nparts.append(bar(next(g), next(g)))"),
    "islice of an endless generator": (COUNTER, "parts += [bar(x) for x in itertools.islice(numbers(), 2, 9, 3)]"),
    "accumulate with a function": (
        "",
        "for x in itertools.accumulate([1, 2, 3], lambda a, b: a * b, initial=2):\n    parts.append(bar(x))",
    ),
    "accumulated poses": (
        "",
        "poses = itertools.accumulate([translation_matrix((1, 0, 0))] * 3, np.matmul, initial=identity_matrix())\n"
        "for pose in poses:\n    parts.append(transform_shape(bar(0), pose))",
    ),
    "items of two arrays": ("", "for x, y in np.nditer([np.arange(3.0), np.ones(3)]):\n    parts.append(bar(float(x), float(y)))"),
    "shapes in an iterable": ("", "parts.extend(list(itertools.chain.from_iterable(bar(i) for i in range(3))))"),
    "alternative constructors": (
        "class Hand:\n    def __init__(self, x):\n        self.x = x\n    @classmethod\n    def of(cls, x, scale=2):\n"
        "        return cls(x * scale)",
        "parts.append(bar(Hand.of(3, scale=4).x))",
    ),
    "a log": ("import logging\nlog = logging.getLogger(__name__)\nlogging.basicConfig(level=logging.DEBUG)",
        "log.debug('part %d', 1)\nparts.append(bar(1))"),
    "a warning": ("import warnings", "warnings.warn('thin')\nparts.append(bar(1))"),
    "a progress bar": ("from tqdm import tqdm", "for x in tqdm(range(3), desc='bars'):\n    parts.append(bar(x))"),
    "a clock": ("", "start = time.perf_counter()\nparts.append(bar(1))\nprint(f'{time.perf_counter() - start:.1f}')"),
    "a date": ("from datetime import date, datetime, timedelta",
        "d = date(1887, 6, 21) + timedelta(days=30)\nparts.append(bar(d.month, d.day))\n"
        "parts.append(bar((datetime(2000, 1, 1) - datetime(1887, 6, 21)).days / 1000))"),
    "a table as csv": ("import csv, io\nROWS = 'x,y\\n1,2\\n3,4\\n'",
        "for row in csv.DictReader(io.StringIO(ROWS)):\n    parts.append(bar(float(row['x']), float(row['y'])))\n"
        "for x, y in list(csv.reader(ROWS.splitlines()))[1:]:\n    parts.append(bar(int(x), int(y), .5))"),
    "bytes in base64": ("import base64", "for b in base64.b64decode('AQMF'):\n    parts.append(bar(b))"),
    "packed numbers": ("import struct", "for x in struct.unpack('<3h', struct.pack('<3h', 1, -2, 3)):\n    parts.append(bar(x))"),
    "decimal numbers": ("from decimal import Decimal", "parts.append(bar(float(Decimal('1.1') + Decimal('2.2'))))"),
    "statistics": ("import statistics", "parts.append(bar(statistics.mean([1, 2, 6]), statistics.median([1, 5, 9])))"),
    "json": ("import json\nT = json.loads('{\"a\": [1, 2.5]}')", "parts.append(bar(*T['a']))"),
    "the order of sets": ("", "for x, y in {(2, 3), (0, 1), (5, 5)}:\n    parts.append(bar(x, y))\n"
        "parts += [bar(x, i) for i, x in enumerate({9, 4, 100, 17})]"),
    "records as keys": ("from dataclasses import dataclass\n@dataclass(frozen=True, order=True)\nclass P:\n    x: int\n    y: int",
        "costs = {P(0, 1): 1, P(0, 1): 2, P(2, 1): 3}\nparts += [bar(costs[P(0, 1)], len(costs))]"),
    "a box whose rest is a list": ("", "x, *rest = compute_shape_max(bar(1))\nparts.append(bar(x, len(rest)))"),
    "a heap": ("import heapq", "h = [3, 1, 2]\nheapq.heapify(h)\nwhile h:\n    parts.append(bar(heapq.heappop(h)))"),
}  # fmt: skip


@pytest.mark.parametrize("name", VALID)
def test_valid_python_is_not_refused(name: str) -> None:
    code = program(*VALID[name])
    translation = SESSION.transpile(Source("valid.py", code))
    assert translation.ok, told(translation.diagnostics)
    evaluated = SESSION.evaluate(Source("valid.scene", translation.text))
    assert evaluated.scene is not None, told(evaluated.diagnostics)
    with contextlib.redirect_stdout(io.StringIO()):
        expected = flatten("__name__ = 'scene'\n" + code)
    assert first_difference(flattened(evaluated.scene), expected) is None


REFUSED = {
    "a clock that decides what is built": ("", "parts.append(bar(time.perf_counter()))", "the scene depends on the time"),
    "a clock in a condition": ("", "parts.append(bar(1))\nwhile time.monotonic() < 3:\n    parts.append(bar(2))",
        "the scene depends on the time"),
    "the date of today": ("from datetime import date", "parts.append(bar(date.today().day))",
        "`datetime.date.today` gives another value in every run"),
    "a module by its name": ("import pandas\nTABLE = pandas.DataFrame([[0, 0]])\nSIZE = len(TABLE.columns)",
        "parts.append(bar(SIZE))", "the module `pandas"),
    "the real cause behind a name": ("from datetime import date\nDATA = [date.today()]\nMONTH = DATA[0].month",
        "parts.append(bar(MONTH))", "`datetime.date.today` gives"),
    "a method of an array, not the axis before it": ("A = np.roll(np.ones((2, 2)), 1, axis=0).dumps()",
        "parts.append(bar(len(A)))", "`dumps` of a ndarray"),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_a_refusal_tells_where_evaluation_ends(name: str) -> None:
    before, body, message = REFUSED[name]
    problem = error_of(program(before, body))
    assert problem.message.startswith(message)
    assert problem.span is not None


def test_an_exception_is_told_in_the_words_of_python() -> None:
    problem = error_of(
        program(
            "class A:\n    def __init_subclass__(cls):\n        pass\nclass B(A):\n    pass",
            "x = [1]\nB()\nparts.append(bar(x[3]))",
        )
    )
    assert problem.message == "Python: IndexError: list index out of range"


def test_a_function_whose_decorator_fails_is_no_unknown_word() -> None:
    """It was left out, so that its calls made nothing: a scene of 40 primitives instead of 117."""
    text = """from helper import *
import inspect
def checked(function):
    names = inspect.signature(function)
    return function
@register()
@checked
def column(digit: int = 0) -> Shape:
    return primitive_call('cube', shape_kwargs={'scale': (1, 1, digit + 1)})
@register()
def root() -> Shape:
    return concat_shapes(*[library_call('column', digit=i) for i in range(2)])
"""
    result = Session().transpile(Source("a.py", text))
    assert not result.ok
    assert "`inspect.signature` is not allowed" in told(result.diagnostics)


def test_subclasses_of_dataclasses_take_their_fields() -> None:
    text = """from helper import *
from dataclasses import dataclass
@dataclass
class Base:
    width: float
    def __getattr__(self, name): return 3  # which is evaluated
class Tower(Base):
    pass
@register()
def root() -> Shape:
    kind = {1: Base}.get(2, Tower)
    return primitive_call('cube', shape_kwargs={'scale': (kind(width=2).width, 1, Tower(3).depth)})
"""
    result = Session().transpile(Source("a.py", text))
    assert result.ok, told(result.diagnostics)
    assert "[2 1 3]" in result.text


MISTAKES = {
    "a misspelled attribute": ("from dataclasses import dataclass\n@dataclass\nclass P:\n    x: float", "p = P(1.0)\nparts.append(bar(p.y))", "AttributeError"),
    "a misspelled method of a list": ("", "parts.apend(bar(1))", "AttributeError"),
    "an argument too many": ("def twice(x):\n    return 2 * x", "parts.append(bar(twice(1, 2)))", "TypeError"),
    "a missing argument": ("def add(x, y):\n    return x + y", "parts.append(bar(add(1)))", "TypeError"),
    "an unknown name": ("", "parts.append(bar(undefined))", "NameError"),
    "an exception of the program": ("", "parts.append(bar(1))\nif len(parts) == 1:\n    raise RuntimeError('stop')", "RuntimeError"),
    "a wrong part of a complex number": ("Z = [2j, 1 + 1j]", "parts.append(bar(Z[0].imaginary))", "AttributeError"),
    "an iterator that has ended": ("", "it = iter([1])\nnext(it)\nparts.append(bar(next(it)))", "StopIteration"),
    "a case for a class without one": (
        "from functools import singledispatch\n@singledispatch\ndef size(x):\n    raise TypeError(x)\n"
        "@size.register\ndef _(x: int):\n    return x",
        "parts.append(bar(size(2), size('a')))",
        "TypeError",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_is_told_at_the_line_of_cpython(name: str) -> None:
    before, body, expected = MISTAKES[name]
    code = program(before, body)
    with pytest.raises(Exception) as caught, contextlib.redirect_stdout(io.StringIO()):
        flatten("__name__ = 'scene'\n" + code)
    assert caught.type.__name__ == expected
    lines = [each.lineno for each in caught.traceback if str(each.path).endswith("<program>")]
    translation = SESSION.transpile(Source("wrong.py", code))
    errors = [d for d in translation.diagnostics if d.is_error]
    if translation.ok:
        errors = [d for d in SESSION.evaluate(Source("wrong.scene", translation.text)).diagnostics if d.is_error]
        assert errors
        return
    assert errors[0].span is not None
    assert code.count("\n", 0, errors[0].span.start) + 1 in lines, told(translation.diagnostics)


UNSUPPORTED = {
    "a library": ("import pandas as pd\nTABLE = pd.DataFrame({'a': [1]})", "parts.append(bar(len(TABLE)))"),
    "a signature": ("import inspect", "parts.append(bar(len(inspect.signature(bar).parameters)))"),
}


@pytest.mark.parametrize("name", UNSUPPORTED)
def test_what_is_not_supported_is_not_blamed_on_the_program(name: str) -> None:
    problem = error_of(program(*UNSUPPORTED[name]))
    assert problem.name in ("python-unsupported", "python-forbidden")
