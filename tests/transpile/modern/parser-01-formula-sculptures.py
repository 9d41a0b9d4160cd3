from __future__ import annotations
import math
import re
from typing import Callable
from helper import *

"""
height curves from formulas, read by a recursive descent parser
"""

TOKEN = re.compile(r"\s*(?:(\d+\.?\d*)|([a-z]+)|(.))")
FUNCTIONS = {"sin": math.sin, "cos": math.cos, "abs": abs, "sqrt": math.sqrt}


class ParseError(ValueError):
    def __init__(self, message: str, position: int):
        super().__init__(f"{message} at {position}")
        self.position = position


class Parser:
    def __init__(self, text: str):
        self.tokens = [m.groups() for m in TOKEN.finditer(text)]
        self.i = 0

    def peek(self) -> str | None:
        return self.tokens[self.i][2] if self.i < len(self.tokens) else None

    def take(self, symbol: str) -> bool:
        if self.peek() == symbol:
            self.i += 1
            return True
        return False

    def parse(self) -> Callable[[float], float]:
        fn = self.expression()
        if self.i < len(self.tokens):
            raise ParseError("unexpected", self.i)
        return fn

    def expression(self):
        fn = self.term()
        while (op := self.peek()) in ("+", "-") and op:
            self.i += 1
            a, b = fn, self.term()
            fn = (lambda a, b: lambda x: a(x) + b(x))(a, b) if op == "+" else (lambda a, b: lambda x: a(x) - b(x))(a, b)
        return fn

    def term(self):
        fn = self.factor()
        while self.take("*"):
            fn = (lambda a, b: lambda x: a(x) * b(x))(fn, self.factor())
        return fn

    def factor(self):
        if self.take("-"):
            inner = self.factor()
            return lambda x: -inner(x)
        if self.take("("):
            inner = self.expression()
            if not self.take(")"):
                raise ParseError("missing )", self.i)
            return inner
        number, name, other = self.tokens[self.i] if self.i < len(self.tokens) else (None, None, None)
        self.i += 1
        if number:
            return lambda x, value=float(number): value
        if name == "x":
            return lambda x: x
        if name in FUNCTIONS:
            outer, inner = FUNCTIONS[name], self.factor()
            return lambda x: outer(inner(x))
        raise ParseError(f"bad token {name or other}", self.i - 1)


@register()
def curve(formula: str, color: tuple) -> Shape:
    try:
        fn = Parser(formula).parse()
    except ParseError as e:
        return loop(3, lambda i: transform_shape(primitive_call('cube', color=(0.9, 0, 0), shape_kwargs={'scale': 0.3}), translation_matrix((i, e.position / 10, 0))))
    xs = [k / 4 for k in range(17)]
    return concat_shapes(*[transform_shape(primitive_call('cube', color=color, shape_kwargs={'scale': (0.22, 0.1 + abs(fn(x)), 0.3)}), translation_matrix((x, fn(x) / 2, 0))) for x in xs])


@register()
def exhibition() -> Shape:
    formulas = ["sin(x)", "x * 0.5 - 1", "abs(sin(2*x)) + 0.2", "sqrt(x) * cos(3*x)", "2 * (x", "-(x - 2) * (x - 2) * 0.3 + 1", "tan(x)", "1 - -x * .5"]
    return concat_shapes(*[transform_shape(library_call('curve', formula=f, color=(0.1 * k, 0.5, 0.9 - 0.1 * k)), translation_matrix((0, 0, -1.2 * k))) for k, f in enumerate(formulas)])
