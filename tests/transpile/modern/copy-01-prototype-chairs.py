from __future__ import annotations
import copy
from helper import *

"""
a lecture hall: chairs cloned from prototypes, shallow and deep
"""


class Chair:
    def __init__(self, color: list[float], parts: dict[str, list[float]]):
        self.color = color
        self.parts = parts
        self.tags: list[str] = []

    def clone(self) -> Chair:
        return copy.deepcopy(self)

    def twin(self) -> Chair:
        return copy.copy(self)

    def __copy__(self) -> Chair:
        other = Chair(self.color, self.parts)
        other.tags = self.tags + ["twin"]
        return other

    def draw(self) -> Shape:
        def box(name: str, y: float, z: float) -> Shape:
            w, h, d = self.parts[name]
            return transform_shape(primitive_call('cube', color=self.color, shape_kwargs={'scale': (w, h, d)}), translation_matrix((0, y, z)))
        _, seat_height, _ = self.parts["leg"]
        back = self.parts["back"][1]
        stud = loop(len(self.tags), lambda i: transform_shape(primitive_call('sphere', color=(1, 1, 1), shape_kwargs={'radius': 0.05}), translation_matrix((0.15 * i - 0.1, seat_height + back, -0.25))))
        return concat_shapes(box("leg", seat_height / 2, 0), box("seat", seat_height, 0), box("back", seat_height + back / 2, -0.25), stud)


@register()
def chair(model: Chair) -> Shape:
    return model.draw()


@register()
def lecture_hall() -> Shape:
    prototype = Chair([0.6, 0.3, 0.2], {"leg": [0.1, 0.5, 0.1], "seat": [0.5, 0.06, 0.5], "back": [0.5, 0.5, 0.05]})
    independent = prototype.clone()
    shared = prototype.twin()
    # what is changed through the twin also changes the prototype, not the clone
    shared.parts["back"][1] = 0.8
    shared.color[0] = 0.2
    shared.color = [*shared.color[:2], 0.9]
    independent.tags.append("own")
    rows = [[prototype] * 4, [independent.clone() for _ in range(4)], [shared, prototype, independent, shared.twin()]]
    rows[0][1] = copy.copy(rows[1][0])
    for i, model in enumerate(rows[1]):
        model.parts["seat"][0] += 0.1 * i
    snapshot = copy.deepcopy(rows)
    rows[2][0].parts["leg"][1] = 0.3
    shapes = []
    for r, row in enumerate(rows + snapshot[2:]):
        step = primitive_call('cube', color=(0.5, 0.5, 0.5), shape_kwargs={'scale': (4, 0.3 * (r + 1), 1)})
        shapes.append(transform_shape(step, translation_matrix((1.5, 0.15 * (r + 1), -1.2 * r))))
        for c, model in enumerate(row):
            shapes.append(transform_shape(library_call('chair', model=model), translation_matrix((c, 0.3 * (r + 1), -1.2 * r))))
    assert snapshot[2][1] is snapshot[0][0]
    return concat_shapes(*shapes)
