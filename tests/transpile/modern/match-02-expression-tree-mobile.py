from __future__ import annotations
from dataclasses import dataclass
from helper import *

"""
a hanging mobile drawn from an expression tree with class patterns
"""

@dataclass
class Num:
    value: float

@dataclass
class Bin:
    op: str
    left: Num | Bin | Neg
    right: Num | Bin | Neg

@dataclass
class Neg:
    inner: Num | Bin | Neg

Expr = Num | Bin | Neg

def evaluate(e: Expr) -> float:
    match e:
        case Num(value=v):
            return v
        case Neg(inner):
            return -evaluate(inner)
        case Bin("+", a, b):
            return evaluate(a) + evaluate(b)
        case Bin("*", Num(0), _) | Bin("*", _, Num(0)):
            return 0
        case Bin(op="*", left=a, right=b):
            return evaluate(a) * evaluate(b)
        case Bin(op=other):
            raise ValueError(f"unknown operator {other}")

def depth(e: Expr) -> int:
    match e:
        case Num():
            return 1
        case Neg(inner=x):
            return 1 + depth(x)
        case Bin(_, a, b):
            return 1 + max(depth(a), depth(b))

@register()
def bob(value: float) -> Shape:
    color = (0.2, 0.6, 0.9) if value >= 0 else (0.9, 0.3, 0.2)
    return primitive_call('sphere', color=color, shape_kwargs={'radius': 0.12 + 0.03 * min(abs(value), 8)})

@register()
def hanging(e: Expr) -> Shape:
    string = primitive_call('cylinder', color=(0.3, 0.3, 0.3), shape_kwargs={'radius': 0.015, 'p0': (0, 0, 0), 'p1': (0, -0.6, 0)})
    down = translation_matrix((0, -0.6, 0))
    match e:
        case Num(v):
            return concat_shapes(string, transform_shape(library_call('bob', value=v), down))
        case Neg(x):
            cube = primitive_call('cube', color=(0.9, 0.8, 0.2), shape_kwargs={'scale': 0.2})
            return concat_shapes(string, transform_shape(concat_shapes(cube, library_call('hanging', e=x)), down))
        case Bin(op, a, b) if op in "+*":
            half = 0.5 * 1.6 ** (depth(e) - 2)
            bar = primitive_call('cube', color=(0.5, 0.35, 0.2) if op == "+" else (0.1, 0.1, 0.1), shape_kwargs={'scale': (2 * half, 0.05, 0.05)})
            arms = [transform_shape(library_call('hanging', e=sub), translation_matrix((side * half, 0, 0))) for side, sub in ((-1, a), (1, b))]
            return concat_shapes(string, transform_shape(concat_shapes(bar, *arms), down))

@register()
def mobile() -> Shape:
    tree = Bin("+", Bin("*", Num(2), Neg(Bin("+", Num(1), Num(3)))), Bin("+", Bin("*", Num(0), Num(9)), Bin("*", Num(5), Num(1.5))))
    total = evaluate(tree)
    ceiling = primitive_call('cube', color=(0.9, 0.9, 0.9), shape_kwargs={'scale': (3, 0.1, 2 + total)})
    return concat_shapes(ceiling, library_call('hanging', e=tree))
