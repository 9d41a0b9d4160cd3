"""Scenes as text and data: a summary, an outline of the entity hierarchy, and the flattened scene as JSON.

The outline merges adjacent parts of the same structure into one line with a count.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from scenelang.interpreter.inspection.numbering import Numbering, number_scene
from scenelang.interpreter.runtime.show import plain_attributes, primitive_attributes, show
from scenelang.interpreter.scene.entity import Entity, Scene, count_words, descendants, primitive_count
from scenelang.interpreter.scene.pose import to_array
from scenelang.interpreter.values.values import IDENTITY, Matrix, Vector

if TYPE_CHECKING:
    from scenelang.interpreter.scene.flatten import FlatScene

MAX_LINES = 2_000  # of an outline
_MAX_COMPARED = 200  # children of an entity whose words are compared
_MAX_ATTRIBUTES_WIDTH = 60  # characters of a line
_MAX_SHOWN_NUMBERS = 9  # of a vector


def outline(scene: Scene, depth: int | None = None, poses: bool = False, expand: bool = False) -> Iterator[str]:
    """Iterate over the lines of the tree of the first frame, at most ``MAX_LINES``.

    Parameters
    ----------
    scene
        Scene to show.
    depth
        Levels below the root to show; None for all.
    poses
        Whether to show the poses of parts.
    expand
        Whether every instance has a line. Otherwise consecutive siblings with the same word and the same child words
        share one, such as ``64 x square <z3> ... <z66>``.
    """
    if scene.animated:
        yield f"{len(scene.frames)} frames; the first:"
    numbering = number_scene(scene)
    stack: list[tuple[str, str, list[tuple[Any, int]]]] = [("", "", [(_RootPart(scene.root), 0)])]
    lines = 0
    while stack:
        prefix, inner, group = stack.pop()
        lines += 1
        if lines > MAX_LINES:
            yield f"... more than {MAX_LINES:,} lines; use --depth"
            return
        part, before = group[0]
        yield prefix + _label(numbering, group, poses=poses)
        level = len(inner) // 3
        groups = _groups(numbering, part.car, before, expand=expand)
        if groups and depth is not None and level >= depth:
            count = sum(map(len, groups))
            yield inner + f"└─ ... {count:,} part{'s' * (count != 1)}"
            continue
        for position in range(len(groups) - 1, -1, -1):
            last = position == len(groups) - 1
            stack.append((inner + ("└─ " if last else "├─ "), inner + ("   " if last else "│  "), groups[position]))


class _RootPart:
    """The root as a part with the identity pose."""

    def __init__(self, root: Entity) -> None:
        self.car = root
        self.cdr = IDENTITY


def _groups(numbering: Numbering, entity: Entity, before: int, *, expand: bool) -> list[list[tuple[Any, int]]]:
    """Return the parts of ``entity``, with runs of similar siblings grouped."""
    groups: list[list[tuple[Any, int]]] = []
    last: Any = None
    for part, count in numbering.children(entity, before):
        signature = _signature(part.car)
        if groups and not expand and signature == last:
            groups[-1].append((part, count))
        else:
            groups.append([(part, count)])
        last = signature
    return groups


def _signature(entity: Entity) -> Any:
    """Return the key that siblings must share to be merged into one line: the word and the words of the children."""
    return entity.word, tuple(part.car.word for part in entity.children[:_MAX_COMPARED]), len(entity.children)


def _label(numbering: Numbering, group: list[tuple[Any, int]], *, poses: bool) -> str:
    """Return the line of a part with its handle and attributes, or of a run of parts with the first and last handle."""
    (part, before), (last_part, last_before) = group[0], group[-1]
    entity = part.car
    first = f"<{numbering.handle(entity, before)}>"
    if len(group) > 1:
        last = f"<{numbering.handle(last_part.car, last_before)}>"
        text = f"{len(group):,} x {entity.word} {first} ... {last}"
    else:
        text = f"{entity.word} {first}"
    z = entity.embedding
    attributes = [f'"{z.text}"'] if z.text else []
    attributes += [f":{name} {_brief(value)}" for name, value in z.attributes.items()]
    joined = " ".join(attributes)
    if joined and len(group) == 1:
        text += "  " + (joined if len(joined) <= _MAX_ATTRIBUTES_WIDTH else joined[: _MAX_ATTRIBUTES_WIDTH - 3] + "...")
    return text + (_pose_text(part.cdr) if poses and len(group) == 1 else "")


def _brief(value: Any) -> str:
    """Format an attribute value for the tree, with floats rounded to four significant digits."""
    if type(value) is float:
        return f"{value:.4g}"
    if type(value) is Vector:
        shown = " ".join(f"{x:.4g}" for x in value[:_MAX_SHOWN_NUMBERS])
        return f"[{shown}{' ...' if len(value) > _MAX_SHOWN_NUMBERS else ''}]"
    return show(value, 40)


def _pose_text(m: Matrix) -> str:
    """Return a pose as text: nothing for the identity, the position, and the linear part if there is one."""
    if m == IDENTITY:
        return ""
    linear = m[0:3] + m[4:7] + m[8:11]
    moved = " ".join(f"{x:.4g}" for x in (m[3], m[7], m[11]))
    if linear == (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0):
        return f"  at [{moved}]"
    rows = " ".join("[" + " ".join(f"{x:.4g}" for x in linear[i : i + 3]) + "]" for i in (0, 3, 6))
    return f"  at [{moved}] turned [{rows}]"


def outline_data(scene: Scene, depth: int | None = None) -> dict[str, Any]:
    """Return the tree of the first frame as plain data, one node per instance.

    It is truncated at ``depth`` levels, and after ``MAX_LINES`` nodes in breadth-first order.
    """
    numbering = number_scene(scene)
    root = _node(numbering, scene.root, 0)
    pending: list[tuple[dict[str, Any], Entity, int, int]] = [(root, scene.root, 0, 0)]
    count = 0
    while pending:
        data, entity, before, level = pending.pop(0)
        if depth is not None and level >= depth:
            continue
        for part, number in numbering.children(entity, before):
            count += 1
            if count > MAX_LINES:
                root["cut"] = True
                return root
            child = _node(numbering, part.car, number)
            child["pose"] = to_array(part.cdr).tolist()
            data["children"].append(child)
            pending.append((child, part.car, number, level + 1))
    return root


def _node(numbering: Numbering, entity: Entity, before: int) -> dict[str, Any]:
    """Return the data of an instance, without its children."""
    return {
        "word": entity.word,
        "handle": f"<{numbering.handle(entity, before)}>",
        "text": entity.embedding.text,
        "attributes": plain_attributes(entity),
        "primitive": entity.is_primitive,
        "children": [],
    }


def flat_json(flat: FlatScene, handles: Sequence[Sequence[str]]) -> Iterator[str]:
    """Serialize a flattened scene as JSON, yielded per primitive to limit memory use.

    Parameters
    ----------
    flat
        The flattened scene.
    handles
        For each frame, the handle of each primitive.
    """
    yield f'{{"root": {json.dumps(flat.word)}, "frames": ['
    for position, (frame, names) in enumerate(zip(flat.frames, handles, strict=True)):
        yield (", " if position else "") + '{"primitives": ['
        words = [json.dumps(entity.word) for entity in frame.primitives]
        attributes = [json.dumps(primitive_attributes(entity)) for entity in frame.primitives]
        paths = [json.dumps(path) for path in frame.paths]
        for i in range(len(frame)):
            k = frame.index[i]
            matrix = [*frame.matrices[i].tolist(), [0.0, 0.0, 0.0, 1.0]]
            handle, path = json.dumps(f"<{names[i]}>"), paths[frame.path_index[i]]
            yield (
                f'{", " if i else ""}{{"word": {words[k]}, "attributes": {attributes[k]}, '
                f'"handle": {handle}, "matrix": {matrix}, "path": {path}}}'
            )
        yield "]}"
    yield "]}"


# Summary of a scene: root, counts and bounds.


def summary(scene: Scene) -> dict[str, Any]:
    """Return the summary as JSON data, accumulated over all frames of a 4D scene.

    ``bounds`` is None without geometry.
    """
    from scenelang.interpreter.scene.bounds import word_box

    box = word_box(scene, None)
    facts: dict[str, Any] = {"root": scene.word}
    if scene.animated:
        facts["frames"] = len(scene.frames)
    return facts | {
        "entities": sum(1 for _ in descendants(*scene.frames)),
        "instances": sum(sum(count_words(root).values()) for root in scene.frames),
        "primitives": sum(primitive_count(root) for root in scene.frames),
        "bounds": {"min": list(box[:3]), "max": list(box[3:])} if box is not None else None,
        **({"setup": [item.to_plain() for item in scene.setup]} if scene.setup else {}),
    }


def summary_rows(facts: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Format the result of ``summary`` as rows of name and value; the two corners of the bounds have a row each."""
    rows = [
        (name, f"{value:,}" if isinstance(value, int) else str(value))
        for name, value in facts.items()
        if name not in ("bounds", "setup")
    ]
    setup = Counter(item["form"] for item in facts.get("setup", ()))
    rows += [(form, f"{count:,}") for form, count in setup.items()]
    corners: Mapping[str, Any] = facts["bounds"] or {}  # None without geometry
    return rows + [(name, "[" + " ".join(f"{x:.6g}" for x in corner) + "]") for name, corner in corners.items()]
