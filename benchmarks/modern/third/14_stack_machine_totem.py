"""
a totem pole described by a small stack language
"""
from helper import *
from collections import ChainMap
from dataclasses import dataclass
from typing import Callable

PROGRAM = """
: face  0.8 head  0.2 eye  -0.2 eye  nose ;
: wings 1.2 wing  -1.2 wing ;
face up 0.9 size face wings up 1.1 size face up 0.7 size wings
"""


@dataclass
class Machine:
    stack: list[float]
    words: dict[str, list[str]]
    y: float = 0.0
    size: float = 1.0

    def pop(self) -> float:
        if not self.stack:
            raise IndexError('stack is empty')
        return self.stack.pop()


def tokenize(text: str) -> tuple[list[str], dict[str, list[str]]]:
    tokens, words, main = iter(text.split()), {}, []
    for token in tokens:
        if token == ':':
            name, body = next(tokens), []
            while (t := next(tokens)) != ';':
                body.append(t)
            words[name] = body
        else:
            main.append(token)
    return main, words


def number(token: str) -> float | None:
    try:
        return float(token)
    except ValueError:
        return None


def head(m: Machine):
    r = m.pop() * m.size
    yield ('cylinder', {'radius': r / 2, 'p0': (0, m.y, 0), 'p1': (0, m.y + m.size, 0)}, (0.55, 0.3, 0.15))


def eye(m: Machine):
    yield ('sphere', {'radius': 0.12 * m.size, 'center': (m.pop() * m.size, m.y + 0.65 * m.size, 0.38 * m.size)}, (0.95, 0.95, 0.85))


def nose(m: Machine):
    yield ('cube', {'scale': (0.15 * m.size, 0.3 * m.size, 0.3 * m.size), 'center': (0, m.y + 0.4 * m.size, 0.45 * m.size)}, (0.8, 0.2, 0.1))


def wing(m: Machine):
    x = m.pop()
    yield ('cube', {'scale': (0.9, 0.25 * m.size, 0.1), 'center': (x * 0.8, m.y + 0.5 * m.size, 0)}, (0.1, 0.4, 0.45))


PRIMITIVES: dict[str, Callable] = {f.__name__: f for f in (head, eye, nose, wing)}


def execute(tokens: list[str], m: Machine):
    for token in tokens:
        if (value := number(token)) is not None:
            m.stack.append(value)
        elif token == 'up':
            m.y += m.size
        elif token == 'size':
            m.size = m.pop()
        elif token in m.words:
            yield from execute(m.words[token], m)
        elif (word := PRIMITIVES.get(token)) is not None:
            yield from word(m)
        else:
            raise KeyError(token)


def commands(text: str):
    main, words = tokenize(text)
    machine = Machine([], words)
    yield from execute(main, machine)


def build(kind: str, options: dict, color) -> Shape:
    center = options.pop('center', None)
    shape = primitive_call(kind, color=color, shape_kwargs=options)
    return transform_shape(shape, translation_matrix(center)) if center else shape


@register()
def totem(scale: float = 1.0) -> Shape:
    carving = concat_shapes(*[build(kind, dict(options), color) for kind, options, color in commands(PROGRAM)])
    return transform_shape(carving, scale_matrix(scale, (0, 0, 0)))


@register()
def totem_circle(count: int = 5, radius: float = 4.0) -> Shape:
    import math
    settings = ChainMap({'color': (0.4, 0.5, 0.3)}, {'color': (1, 1, 1), 'thickness': 0.2})
    meadow = primitive_call('cylinder', color=settings['color'], shape_kwargs={'radius': radius * 1.4, 'p0': (0, -settings['thickness'], 0), 'p1': (0, 0, 0)})
    poles = []
    for k in range(count):
        a = math.tau * k / count
        pole = library_call('totem', scale=0.8 + 0.1 * k)
        poles.append(transform_shape(pole, translation_matrix((radius * math.sin(a), 0, radius * math.cos(a))) @ rotation_matrix(a, (0, 1, 0), (0, 0, 0))))
    return concat_shapes(meadow, *poles)
