"""Compare the import of Blender scripts with Blender: `python benchmarks/blender_scripts.py FOLDER [--bpy PYTHON]`.

Prints for every script: equal, refused (with the message), or different (with the first difference), and the counts.
An object is equal if its box and volume are within .1 % of those in Blender, as the script is or with its round
primitives at 256 sides, and its linear color within .001. Flat and open meshes have no volume: areas are compared.
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
from collections import defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.blender.importing import converted
from scenelang.backends.exports.plan import surface_of
from scenelang.backends.surfaces.appearance import look_of
from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.scene.entity import Entity
from scenelang.session.session import Options, Session

FloatArray = npt.NDArray[np.float64]
HERE = Path(__file__).parent
_TO_BLENDER = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
_SEGMENTS = 256
Row = dict[str, Any]


def reference(scripts: Sequence[Path], table: Path, python: str) -> dict[str, Any]:
    """Return the measures of scripts in Blender; those in the table are not measured again."""
    known = json.loads(table.read_text()) if table.exists() else {}
    missing = [str(path) for path in scripts if path.name not in known]
    if missing:
        subprocess.run([python, str(HERE / "blender_reference.py"), str(table), *missing], check=True)
        known = json.loads(table.read_text())
    return {path.name: known[path.name] for path in scripts}


# Written apart from the list of the converter, which this measures.
_SIDES = frozenset((
    "l", "r", "left", "right", "fl", "fr", "bl", "br", "rl", "rr", "tl", "tr",
    "front", "back", "rear", "top", "bottom", "upper", "lower", "inner", "outer",
))  # fmt: skip


def key_of(name: str) -> str:
    """Return what of a name stays when it becomes a word that equal things share: no numbers and no sides."""
    parts = re.findall(r"[a-z]+", re.sub(r"(?<=[a-z])(?=[A-Z])", " ", name).casefold())
    return "".join(part for part in parts if part not in _SIDES and len(part) > 1) or "".join(parts)


def rows_of(root: Entity) -> list[Row]:
    """Return the measures of the objects of a scene, in Blender's axes."""
    found: list[Row] = []
    for entity, matrix in _objects(root, np.eye(4)):
        parts = [(e, matrix @ m) for e, m in _own(entity, np.eye(4))]
        row = _measured(entity.word, parts)
        if row is not None:
            found.append(row)
    return found


def _children(entity: Entity) -> Iterator[tuple[Entity, FloatArray]]:
    for pair in entity.children:
        child, pose = pair.car, pair.cdr
        matrix = np.eye(4)
        matrix[:3] = np.array(pose).reshape(-1)[:12].reshape(3, 4)
        yield child, matrix


def _objects(entity: Entity, matrix: FloatArray) -> Iterator[tuple[Entity, FloatArray]]:
    """Iterate over the entities that have primitives of their own."""
    if entity.is_primitive:
        return
    if any(child.is_primitive for child, _ in _children(entity)):
        yield entity, matrix
    for child, pose in _children(entity):
        yield from _objects(child, matrix @ pose)


def _own(entity: Entity, matrix: FloatArray) -> Iterator[tuple[Entity, FloatArray]]:
    for child, pose in _children(entity):
        if child.is_primitive:
            yield child, matrix @ pose


def _measured(word: str, parts: Sequence[tuple[Entity, FloatArray]]) -> Row | None:
    points, volume, area = [], 0.0, 0.0
    for primitive, matrix in parts:
        surface = surface_of(primitive, _SEGMENTS)
        if surface is None:
            continue
        placed = (surface.vertices @ matrix[:3, :3].T + matrix[:3, 3]) @ _TO_BLENDER.T
        a, b, c = np.moveaxis(placed[surface.faces], 1, 0)
        center = placed.mean(axis=0)
        volume += abs(float(np.einsum("ij,ij->", a - center, np.cross(b - center, c - center)) / 6))
        area += float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)
        points.append(placed)
    if not points:
        return None
    every = np.concatenate(points)
    color = list(look_of(parts[0][0]).color)
    return {
        "name": word,
        "low": every.min(axis=0),
        "high": every.max(axis=0),
        "volume": volume,
        "area": area,
        "color": color,
    }


def difference(ours: Row, theirs: Row, room: float = 1.0) -> str | None:
    """Return what differs between two measures of an object, None if nothing does."""
    low, high = np.array(theirs["low"]), np.array(theirs["high"])
    extent = float((high - low).max()) or 1e-9
    gap = 1.01e-3 * room * extent + 2e-6 * float(np.abs([low, high]).max())
    if np.abs(ours["low"] - low).max() > gap or np.abs(ours["high"] - high).max() > gap:
        boxes = [np.round(each, 4).tolist() for each in (ours["low"], ours["high"], low, high)]
        return f"box {boxes[:2]}, not {boxes[2:]}"
    if theirs["volume"] is None:
        if abs(ours["area"] / 2 - theirs["area"]) > 2e-3 * theirs["area"]:
            return f"area {ours['area'] / 2:.5g}, not {theirs['area']:.5g}"
    elif abs(ours["volume"] - theirs["volume"]) > 1.01e-3 * room * theirs["volume"] + 1e-12:
        return f"volume {ours['volume']:.5g}, not {theirs['volume']:.5g}"
    if theirs["color"] is not None and np.abs(np.clip(theirs["color"], 0, 1) - ours["color"]).max() > 1e-3:
        return f"color {np.round(ours['color'], 3).tolist()}, not {np.round(theirs['color'], 3).tolist()}"
    return None


def compared(ours: Sequence[Row], variants: Sequence[Sequence[Row]], room: float) -> str | None:
    """Return the first difference between a frame and its variants in Blender; None if there is none."""
    by_key: dict[str, list[Row]] = defaultdict(list)
    for row in ours:
        by_key[key_of(row["name"])].append(row)
    named = [{row["name"]: row for row in variant} for variant in variants]
    for row in variants[0]:
        choices = by_key[key_of(row["name"])]
        if not choices:
            return f"`{row['name']}` is missing"
        reasons = []
        for i, choice in enumerate(choices):
            own = [difference(choice, variant[row["name"]], room) for variant in named if row["name"] in variant]
            if None in own:
                del choices[i]
                break
            reasons.append(own[0])
        else:
            nearest = min(reasons, key=lambda text: not str(text).startswith(("volume", "color", "area")))
            return f"`{row['name']}`: {nearest}"
    rest = [row["name"] for rows in by_key.values() for row in rows]
    return f"`{rest[0]}` is not in Blender" if rest else None


def verdict(path: Path, measured: dict[str, Any], save: Path | None = None) -> tuple[str, str]:
    """Return the verdict about a script, with its reason."""
    if "frames" not in measured["as is"]:
        return "invalid", measured["as is"]["error"][-200:]
    try:
        text, _ = converted(Source(str(path), path.read_text("utf-8")), path.stem)
    except SceneError as error:
        line = error.span.source.text.count("\n", 0, error.span.start) + 1 if error.span is not None else 0
        return "refused", f"line {line}: {error.message}"
    if save is not None:
        (save / f"{path.stem}.scene").write_text(text)
    session = Session(Options())
    result = session.evaluate(Source(f"{path.stem}.scene", text))
    if result.scene is None:
        return "different", f"the program fails: {next(d.message for d in result.diagnostics if d.is_error)}"
    names = [name for name in ("as is", "round", "all round", "coarse") if "frames" in measured.get(name, {})]
    variants = [measured[name]["frames"] for name in names]
    room = 2.5 if "coarse" in names else 1.0  # polygons of 128 sides lack .12 % of a sphere
    moments = list(variants[0])
    frames = result.scene.frames
    numbers = [0] if len(moments) == 1 else [0, len(frames) // 2, len(frames) - 1]
    if (len(frames) > 1) != (len(moments) > 1):
        return "different", f"{len(frames)} frames, {len(moments)} in Blender"
    for moment, number in zip(moments, numbers, strict=True):
        reason = compared(rows_of(frames[number]), [variant[moment] for variant in variants], room)
        if reason is not None:
            return "different", f"{reason} (frame {moment})" if len(moments) > 1 else reason
    return "equal", f"{text.count(chr(10))} lines"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--bpy", default="python", help="Python that has bpy 5")
    parser.add_argument("--table", type=Path, help="table of Blender's measures (default: in the folder)")
    parser.add_argument("--save", type=Path, help="folder for the programs")
    parser.add_argument("--only", help="regular expression of names")
    parser.add_argument("--quiet", action="store_true", help="print the counts only")
    arguments = parser.parse_args()
    scripts = [
        p for p in sorted(arguments.folder.glob("*.py")) if not arguments.only or re.search(arguments.only, p.name)
    ]
    table = reference(scripts, arguments.table or arguments.folder / "blender.json", arguments.bpy)
    counts: dict[str, int] = defaultdict(int)
    for path in scripts:
        kind, reason = verdict(path, table[path.name], arguments.save)
        counts[kind] += 1
        if not arguments.quiet:
            print(f"{kind:10} {path.name}: {reason}", flush=True)
    print(", ".join(f"{count} {kind}" for kind, count in sorted(counts.items())))


if __name__ == "__main__":
    main()
