from contextlib import contextmanager
from helper import *

"""
a pagoda whose storeys are pushed on a matrix stack
"""

STACK: List[np.ndarray] = [np.eye(4)]
PARTS: List[Shape] = []


@contextmanager
def moved(x: float = 0, y: float = 0, z: float = 0):
    STACK.append(STACK[-1] @ translation_matrix((x, y, z)))
    try:
        yield STACK[-1]
    finally:
        STACK.pop()


@contextmanager
def scaled(factor: float):
    STACK.append(STACK[-1] @ scale_matrix(factor, (0, 0, 0)))
    yield
    STACK.pop()


@contextmanager
def collecting():
    saved, PARTS[:] = PARTS[:], []
    result: list = []
    try:
        yield result
    finally:
        result.extend(PARTS)
        PARTS[:] = saved


def emit(shape: Shape) -> None:
    PARTS.append(transform_shape(shape, STACK[-1]))


def storey(level: int) -> None:
    emit(primitive_call("cube", color=(0.75, 0.2, 0.15), shape_kwargs={"scale": (2, 1, 2)}))
    with moved(y=0.6):
        emit(primitive_call("cube", color=(0.25, 0.3, 0.28), shape_kwargs={"scale": (3, 0.15, 3)}))
        for sx in (-1, 1):
            for sz in (-1, 1):
                with moved(1.5 * sx, 0.1, 1.5 * sz):
                    emit(primitive_call("sphere", color=(0.9, 0.7, 0.2), shape_kwargs={"radius": 0.12}))
    if level > 0:
        with moved(y=1.15), scaled(0.82):
            storey(level - 1)
    else:
        with moved(y=0.7) as top:
            emit(primitive_call("cylinder", color=(0.9, 0.7, 0.2), shape_kwargs={"radius": 0.08, "p0": (0, 0, 0), "p1": (0, 1.5, 0)}))
            print("top at", top[1, 3])


@register("one pagoda")
def pagoda(levels: int) -> Shape:
    with collecting() as parts:
        storey(levels - 1)
    assert len(STACK) == 1
    return concat_shapes(*parts)


@register("temple garden")
def temple_garden() -> Shape:
    lawn = primitive_call("cube", color=(0.35, 0.5, 0.3), shape_kwargs={"scale": (14, 0.1, 8)})
    towers = [(3, -4.0), (5, 0.0), (2, 4.0)]
    return concat_shapes(
        transform_shape(lawn, translation_matrix((0, -0.55, 0))),
        *[transform_shape(library_call("one pagoda", levels=n), translation_matrix((x, 0, 0))) for n, x in towers],
    )
