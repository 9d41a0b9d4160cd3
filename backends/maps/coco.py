"""Annotations in COCO's JSON form: one per instance that is seen, at every level of the hierarchy.

Masks are run lengths down the columns, as COCO has them. Beyond COCO's own fields an annotation has ``depth`` (of the
hierarchy), ``instance`` and ``parent`` (numbers in the maps), ``path`` (child positions from the root), ``handle``,
``bbox_full`` (also what is hidden or outside the picture, exact), ``box3d`` (the entity's box in its own frame, and the
pose of that frame in the world).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.maps.boxes import Boxes
from scenelang.backends.maps.truth import Truth, boxes_of

IntArray = npt.NDArray[np.int64]


def annotations_of(truth: Truth, boxes: Boxes, handles: Sequence[str], most: int) -> list[dict[str, Any]]:
    """The annotations of one shot without ids of their own: ``category`` is a word, ``handles`` those of all
    instances. The ``most`` instances that are highest in the hierarchy."""
    ancestry = truth.ancestry
    seen = np.flatnonzero(boxes.area > 0)[:most]
    low, high = boxes_of(ancestry, seen)
    masks = _masks(truth, seen, boxes)
    found = []
    for k, instance in enumerate(seen.tolist()):
        x0, y0, x1, y1 = (int(edge) for edge in boxes.visible[instance])
        entity = ancestry.entity(instance)
        full = boxes.full[instance]
        annotation = {
            "category": entity.word,
            "bbox": [x0, y0, x1 - x0, y1 - y0],
            "area": int(boxes.area[instance]),
            "segmentation": {"size": [truth.camera.height, truth.camera.width], "counts": masks[k]},
            "iscrowd": 0,
            "instance": instance,
            "parent": int(ancestry.parent[instance]),
            "depth": int(ancestry.depth[instance]),
            "path": list(ancestry.path(instance)),
            "handle": handles[instance],
            "bbox_full": None if np.isnan(full).any() else _corner_and_size(full),
            "box3d": {
                "min": low[k].tolist(),
                "max": high[k].tolist(),
                "pose": [*ancestry.poses[instance].tolist(), [0.0, 0.0, 0.0, 1.0]],
            },
        }
        found.append(annotation)
    return found


def _corner_and_size(box: npt.NDArray[np.float64]) -> list[float]:
    x0, y0, x1, y1 = box.tolist()
    return [x0, y0, x1 - x0, y1 - y0]


def _masks(truth: Truth, seen: IntArray, boxes: Boxes) -> list[list[int]]:
    """The run lengths of the instances ``seen``, level by level of the hierarchy, each inside its own box."""
    out: dict[int, list[int]] = {}
    for depth in range(truth.ancestry.deepest + 1):
        map_ = truth.at_depth(depth)
        for instance in seen[truth.ancestry.depth[seen] == depth].tolist():
            out[instance] = _run_lengths(map_, instance, boxes.visible[instance])
    return [out[instance] for instance in seen.tolist()]


def _run_lengths(map_: IntArray, instance: int, box: IntArray) -> list[int]:
    """COCO's run lengths of ``map_ == instance`` (H, W), which is false outside ``box``: zeros first, column-wise."""
    height, width = map_.shape
    x0, y0, x1, y1 = (int(edge) for edge in box)
    columns, rows = np.nonzero((map_[y0:y1, x0:x1] == instance).T)
    places = (columns + x0) * height + rows + y0
    breaks = np.flatnonzero(np.diff(places) > 1)
    starts = np.concatenate([places[:1], places[breaks + 1]])
    ends = np.concatenate([places[breaks], places[-1:]]) + 1
    edges = np.stack([starts, ends], axis=1).reshape(-1)
    lengths: list[int] = np.diff(np.concatenate([[0], edges, [height * width]])).tolist()
    return lengths if lengths[-1] else lengths[:-1]


def dataset(images: Sequence[dict[str, Any]], annotations: Sequence[Sequence[dict[str, Any]]]) -> dict[str, Any]:
    """One COCO document: ``images`` with ``file_name``, ``width``, ``height``, and the annotations of each."""
    words = sorted({annotation["category"] for one in annotations for annotation in one})
    number = {word: i + 1 for i, word in enumerate(words)}
    listed: list[dict[str, Any]] = []
    for image, one in enumerate(annotations, start=1):
        for annotation in one:
            rest = {name: value for name, value in annotation.items() if name != "category"}
            listed.append(
                {"id": len(listed) + 1, "image_id": image, "category_id": number[annotation["category"]], **rest}
            )
    return {
        "info": {"description": "maps of scenes, written by scenelang"},
        "images": [{"id": i, **image} for i, image in enumerate(images, start=1)],
        "categories": [{"id": i, "name": word, "supercategory": "word"} for word, i in number.items()],
        "annotations": listed,
    }
