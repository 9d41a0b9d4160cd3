"""Exports as glTF 2.0: .glb in one file, .gltf with its buffer in a .bin beside it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from urllib.parse import quote

from scenelang.backends.exports.export import FPS, INSTANCES, Job, mesh_backend
from scenelang.backends.exports.gltf_document import Document
from scenelang.backends.exports.gltf_nodes import Nodes
from scenelang.backends.exports.gltf_tracks import Tracks
from scenelang.backends.exports.items import Item, Plan, cut_below, distinct
from scenelang.backends.exports.merging import segments_for
from scenelang.backends.exports.timeline import Moving, matched
from scenelang.grammar.diagnostics import LimitError
from scenelang.interpreter.values import IDENTITY

_HINT = "raise --instance-limit, or export a part of the scene"


def write(job: Job, path: Path) -> None:
    """Write a .glb, or a .gltf and its .bin, at ``path``. Raises SceneError and LimitError."""
    document = document_of(job)
    job.progress(0.9)
    if path.suffix.lower() == ".gltf":
        buffer = path.with_suffix(".bin")
        if document.size:
            with buffer.open("wb") as file:
                file.writelines(document.chunks)
        path.write_bytes(document.to_json(job.plan.word, quote(buffer.name)))
        return
    with path.open("wb") as file:
        file.writelines(document.to_glb(job.plan.word))


def document_of(job: Job) -> Document:
    """The glTF document of a plan. Raises LimitError when it would be too large."""
    plan = cut_below(job.plan, job.instances)
    whole = [item.entity for item in distinct(*plan.roots) if item.merged]
    document = Document(segments_for(whole, "the merged meshes", _HINT))
    nodes = Nodes(document)
    if plan.animated:
        _add_frames(nodes, plan, job.fps)
    else:
        nodes.prepare(plan.roots)
        nodes.add_still(plan.roots[0], IDENTITY, None)
    if document.is_too_large:
        raise LimitError("size", "the meshes have more than the 4 GB that a glTF file can hold", hint=_HINT)
    return document


def _add_frames(nodes: Nodes, plan: Plan, fps: float) -> None:
    root = matched(plan.roots)
    nodes.prepare(list(_fixed_items(root)))
    tracks = Tracks(nodes.document, fps)
    nodes.add_moving(root, tracks)
    tracks.finish(plan.word)


def _fixed_items(root: Moving) -> Iterator[Item]:
    waiting = [root]
    while waiting:
        moving = waiting.pop()
        if moving.fixed is not None:
            yield moving.fixed
        waiting.extend(moving.children)


GLTF = mesh_backend(
    "gltf",
    "glTF 2.0 with the hierarchy of entities and 4D animation, for other 3D programs",
    (".glb", ".gltf"),
    write,
    animated=True,
    options=(INSTANCES, FPS),
)
