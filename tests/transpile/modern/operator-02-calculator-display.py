import operator
from typing import Callable
from helper import *

"""
a desk calculator: results of operators become seven segment digits
"""

OPS: dict[str, Callable] = {
    "+": operator.add, "-": operator.sub, "*": operator.mul, "//": operator.floordiv, "%": operator.mod,
    "**": operator.pow, "&": operator.and_, "|": operator.or_, "^": operator.xor, "<<": operator.lshift, ">>": operator.rshift,
}

SEGMENTS = {
    "0": "abcdef", "1": "bc", "2": "abged", "3": "abgcd", "4": "fgbc", "5": "afgcd", "6": "afgedc", "7": "abc", "8": "abcdefg", "9": "abcdfg", "-": "g",
}

PLACES = {"a": (0, 1, 0), "g": (0, 0.5, 0), "d": (0, 0, 0), "f": (-0.25, 0.75, 1), "b": (0.25, 0.75, 1), "e": (-0.25, 0.25, 1), "c": (0.25, 0.25, 1)}


def rpn(expression: str) -> int:
    stack: list[int] = []
    for token in expression.split():
        if token in OPS:
            b, a = stack.pop(), stack.pop()
            stack.append(OPS[token](a, b))
        else:
            stack.append(int(token))
    (result,) = stack
    return result


@register()
def digit(ch: str) -> Shape:
    parts = []
    for s in SEGMENTS[ch]:
        x, y, upright = PLACES[s]
        scale = (0.06, 0.4, 0.05) if upright else (0.4, 0.06, 0.05)
        parts.append(transform_shape(primitive_call('cube', color=(0.9, 0.2, 0.1), shape_kwargs={'scale': scale}), translation_matrix((x, y, 0))))
    return concat_shapes(*parts)


@register()
def display(expression: str) -> Shape:
    text = str(rpn(expression))
    digits = loop(len(text), lambda i: transform_shape(library_call('digit', ch=text[i]), translation_matrix((0.7 * (i - len(text)), 0, 0.06))))
    screen = transform_shape(primitive_call('cube', color=(0.05, 0.1, 0.05), shape_kwargs={'scale': (4, 1.4, 0.05)}), translation_matrix((-1.8, 0.5, 0)))
    return concat_shapes(screen, digits)


@register()
def calculator_wall() -> Shape:
    programs = ["2 10 **", "7 3 - 100 *", "255 170 & 85 |", "1 12 << 96 ^", "-17 5 //", "-17 5 % 3 >>", "12 34 + 56 * 2 -"]
    shapes = [transform_shape(library_call('display', expression=p), translation_matrix((5 * (k % 2), -2 * (k // 2), 0))) for k, p in enumerate(programs)]
    flags = [operator.lt(1, 2), operator.contains([1, 2], 3), operator.not_([]), operator.truth(""), operator.ge(2, 2)]
    lamps = [transform_shape(primitive_call('sphere', color=(0.1, 0.9, 0.2) if f else (0.2, 0.2, 0.2), shape_kwargs={'radius': 0.12}), translation_matrix((0.4 * k, 2, 0))) for k, f in enumerate(flags)]
    return concat_shapes(*shapes, *lamps)
