"""A small model of the reference implementation's helper API, for tests only: it runs a program in CPython.

`extract` takes the program out of a response, `flatten` runs it and gives the structure of a golden file:
`{"kind", "root", "seed", "frames": [{"primitives": [..]}]}`. Programs are executed, so give it only programs of this
folder. Rules: the call graph decides the root (`find_root`); both random streams have seed 0 just before the root is
evaluated; boxes are exact and come as float32 arrays; a block's box is that of its cells and deletions have none.
"""

from __future__ import annotations

import ast
import contextlib
import functools
import gzip
import inspect
import io
import json
import math
import random
import sys
import types
import typing
import warnings
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

Shape = list[dict[str, Any]]
Matrix = np.ndarray[Any, Any]

BLOCK_PRIMITIVES = ("set_cuboid", "delete_blocks")
SOLID_PRIMITIVES = ("cube", "sphere", "cylinder")
ALIASES = ("helper", "minecraft_helper", "mi_helper")  # module names a program may import the API from
DIGITS = 7  # golden files round numbers so


class ProgramError(Exception):
    """The program has no root or returns something that is not a shape."""


def extract(response: str) -> str:
    """The program in a response: from the first line that starts with "```python" to the next "```", else all of it."""
    lines = response.splitlines(keepends=True)
    for start, line in enumerate(lines):
        if line.startswith("```python"):
            return "".join(lines[start + 1 :]).split("```", 1)[0]
    return response


# --- matrices -----------------------------------------------------------------------------------------------------


def translation_matrix(offset: Any) -> Matrix:
    matrix = np.eye(4)
    matrix[:3, 3] = np.asarray(offset, float)[:3]
    return matrix


def rotation_matrix(angle: float, direction: Any, point: Any = None) -> Matrix:
    """Right-handed rotation about the axis through `point` along `direction`."""
    axis = np.asarray(direction, float)[:3]
    axis = axis / np.linalg.norm(axis)
    skew = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    linear = math.cos(angle) * np.eye(3) + math.sin(angle) * skew + (1 - math.cos(angle)) * np.outer(axis, axis)
    return _about(linear, point)


def scale_matrix(scale: Any, origin: Any = None) -> Matrix:
    """Scaling by one number or three about `origin`."""
    return _about(np.diag(np.broadcast_to(np.asarray(scale, float), 3)), origin)


def reflection_matrix(point: Any, normal: Any) -> Matrix:
    """Mirror image in the plane through `point` with the given normal."""
    axis = np.asarray(normal, float)[:3]
    axis = axis / np.linalg.norm(axis)
    return _about(np.eye(3) - 2 * np.outer(axis, axis), point)


def identity_matrix() -> Matrix:
    return np.eye(4)


def _about(linear: Matrix, point: Any) -> Matrix:
    matrix = np.eye(4)
    matrix[:3, :3] = linear
    if point is not None:
        p = np.asarray(point, float)[:3]
        matrix[:3, 3] = p - linear @ p
    return matrix


# --- shapes -------------------------------------------------------------------------------------------------------


def _as_shape(value: Any) -> Shape:
    """A list of primitives; one bare primitive counts as a list of one."""
    if isinstance(value, dict):
        return [value]
    if not isinstance(value, (list, tuple)) or not all(isinstance(p, dict) for p in value):
        raise TypeError(f"not a shape: {type(value).__name__}")
    return list(value)


def concat_shapes(*shapes: Any) -> Shape:
    return [primitive for shape in shapes for primitive in _as_shape(shape)]


def transform_shape(shape: Any, pose: Any) -> Shape:
    matrix = np.asarray(pose, float)
    if matrix.shape != (4, 4):
        raise TypeError(f"not a pose: {pose!r}")
    return [{**primitive, "matrix": matrix @ primitive["matrix"]} for primitive in _as_shape(shape)]


def loop(n: int, fn: Callable[[int], Any]) -> Shape:
    return concat_shapes(*[fn(i) for i in range(n)])


def _corners(primitive: Mapping[str, Any]) -> tuple[Matrix, Matrix]:
    """The exact box of one primitive: lower and upper corner."""
    matrix = primitive["matrix"]
    linear, offset = matrix[:3, :3], matrix[:3, 3]
    shape = primitive["shape"]
    if shape == "cube":
        reach = np.abs(linear).sum(axis=1) / 2
        return offset - reach, offset + reach
    if shape == "sphere":
        reach = np.linalg.norm(linear, axis=1)
        return offset - reach, offset + reach
    if shape == "block":
        size = linear @ np.ones(3)
        return np.minimum(offset, offset + size), np.maximum(offset, offset + size)
    p0, p1 = np.asarray(primitive["p0"]), np.asarray(primitive["p1"])
    axis = p1 - p0
    length = np.linalg.norm(axis)
    across = np.eye(3) - np.outer(axis, axis) / length**2 if length else np.eye(3)
    reach = primitive["radius"] * np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", linear, across, linear), 0))
    ends = np.stack([linear @ p0 + offset, linear @ p1 + offset])
    return ends.min(axis=0) - reach, ends.max(axis=0) + reach


def _box(shape: Any) -> tuple[Matrix, Matrix]:
    pairs = [_corners(p) for p in _as_shape(shape) if p.get("block_type") != "minecraft:air"]
    if not pairs:
        return np.full(3, -0.5), np.full(3, 0.5)
    return np.min([lower for lower, _ in pairs], axis=0), np.max([upper for _, upper in pairs], axis=0)


def compute_shape_min(shape: Any) -> Matrix:
    return _box(shape)[0].astype(np.float32)


def compute_shape_max(shape: Any) -> Matrix:
    return _box(shape)[1].astype(np.float32)


def compute_shape_center(shape: Any) -> Matrix:
    lower, upper = _box(shape)
    return ((lower + upper) / 2).astype(np.float32)


def compute_shape_sizes(shape: Any) -> Matrix:
    lower, upper = _box(shape)
    return (upper - lower).astype(np.float32)


# --- one run of one program ---------------------------------------------------------------------------------------


class Run:
    """The registry of one program and the helper functions that need it."""

    def __init__(self) -> None:
        self.library: dict[str, tuple[Callable[..., Any], str]] = {}
        self.animation: tuple[str, Callable[..., Any]] | None = None
        self.path: list[str] = []
        self.warnings: list[str] = []

    def register(self, docstring: str | None = None) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
        def decorator(function: Callable[..., Any]) -> Callable[..., Any]:
            name = function.__name__

            @functools.wraps(function)
            def call(*args: Any, **kwargs: Any) -> Any:
                self.path.append(name)
                try:
                    return function(*args, **kwargs)
                finally:
                    self.path.pop()

            self.library[name] = call, name if docstring is None else docstring
            return call

        return decorator

    def register_animation(self, docstring: str | None = None) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
        def decorator(function: Callable[..., Any]) -> Callable[..., Any]:
            self.animation = function.__name__, function
            return function

        return decorator

    def find(self, name: str) -> str | None:
        """A function's key by name, else by docstring, else by the docstring up to the first semicolon."""
        if name in self.library:
            return name
        for key, (_, docstring) in self.library.items():
            if docstring == name:
                return key
        for key, (_, docstring) in self.library.items():
            if docstring.split(";")[0].strip() == name:
                return key
        return None

    def library_call(self, name: str, /, **kwargs: Any) -> Any:
        key = self.find(name)
        if key is None:
            self.warnings.append(name)
            print(f"{name} not found")
            return []
        return self.library[key][0](**kwargs)

    def primitive_call(
        self, name: str, shape_kwargs: Mapping[str, Any] | None = None, color: Any = (1.0, 1.0, 1.0), **kwargs: Any
    ) -> Shape:
        given = {**(shape_kwargs or {}), **kwargs}
        if name in BLOCK_PRIMITIVES:
            return [self._block(name, given)]
        matrix = np.eye(4)
        primitive: dict[str, Any] = {"shape": name, "matrix": matrix}
        if name == "cube":
            matrix[:3, :3] = np.diag(np.broadcast_to(np.asarray(given.pop("scale", 1), float), 3))
        elif name == "sphere":
            matrix[:3, :3] *= float(given.pop("radius", 1))
        elif name == "cylinder":
            primitive["radius"] = float(given.pop("radius", 1))
            for key, default in (("p0", (0, 0, 0)), ("p1", (0, 0, 1))):
                primitive[key] = [float(np.float32(x)) for x in given.pop(key, default)]
        else:
            raise ValueError(f"unknown primitive: {name}")
        if given:
            raise TypeError(f"{name} takes no {', '.join(given)}")
        primitive["color"] = [min(max(float(x), 0.0), 1.0) for x in color[:3]]
        primitive["path"] = list(self.path)
        return [primitive]

    def _block(self, name: str, given: dict[str, Any]) -> dict[str, Any]:
        matrix = np.eye(4)
        matrix[:3, :3] = np.diag(np.broadcast_to(np.asarray(given.pop("scale", (1, 1, 1)), float), 3))
        delete = name == "delete_blocks"
        block_type = "minecraft:air" if delete else str(given.pop("block_type"))
        block_kwargs = {} if delete else dict(given.pop("block_kwargs", None) or {})
        fill = True if delete else bool(given.pop("fill", True))
        if given:
            raise TypeError(f"{name} takes no {', '.join(given)}")
        return {
            "shape": "block",
            "matrix": matrix,
            "block_type": block_type,
            "block_kwargs": block_kwargs,
            "fill": fill,
            "path": list(self.path),
        }

    def names(self) -> dict[str, Any]:
        """What `from helper import *` brings."""
        found: dict[str, Any] = {
            "Shape": Shape,
            "P": Any,
            "T": Any,
            "math": math,
            "np": np,
            "numpy": np,
            "random": random,
            "register": self.register,
            "register_animation": self.register_animation,
            "library_call": self.library_call,
            "primitive_call": self.primitive_call,
        }
        for function in (
            concat_shapes,
            transform_shape,
            loop,
            translation_matrix,
            rotation_matrix,
            scale_matrix,
            reflection_matrix,
            identity_matrix,
            compute_shape_center,
            compute_shape_min,
            compute_shape_max,
            compute_shape_sizes,
        ):
            found[function.__name__] = function
        for name in (
            "Any",
            "Callable",
            "Dict",
            "Generator",
            "Iterator",
            "List",
            "Literal",
            "Optional",
            "Tuple",
            "Union",
        ):
            found[name] = getattr(typing, name)
        return found


# --- the call graph -----------------------------------------------------------------------------------------------


def _mentions(node: ast.AST) -> tuple[set[str], set[str]]:
    """Names given to `library_call` as literals, and all plain names read, within a function."""
    called: set[str] = set()
    read: set[str] = set()
    for inner in ast.walk(node):
        if isinstance(inner, ast.Call) and isinstance(inner.func, ast.Name) and inner.func.id == "library_call":
            if inner.args and isinstance(inner.args[0], ast.Constant):
                called.add(str(inner.args[0].value))
        elif isinstance(inner, ast.Name) and isinstance(inner.ctx, ast.Load):
            read.add(inner.id)
    return called, read


def call_graph(run: Run, tree: ast.Module, *, through_plain: bool = True) -> dict[str, set[str]]:
    """Which registered function calls which; calls within plain functions count as their callers' own."""
    by_line: dict[int, ast.AST] = {}
    plain: dict[str, ast.AST] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef):
            for line in (node.lineno, *(d.lineno for d in node.decorator_list)):
                by_line[line] = node
    for node in tree.body:
        if isinstance(node, ast.FunctionDef):
            plain[node.name] = node
    graph: dict[str, set[str]] = {}
    for name, (function, _) in run.library.items():
        start = inspect.unwrap(function).__code__.co_firstlineno
        pending, seen, callees = [by_line[start]], set[int](), set[str]()
        while pending:
            node = pending.pop()
            seen.add(id(node))
            called, read = _mentions(node)
            callees |= {key for key in map(run.find, called) if key is not None}
            callees |= {other for other in read if other in run.library and other in plain}
            if through_plain:
                pending += [plain[r] for r in read if r in plain and r not in run.library and id(plain[r]) not in seen]
        graph[name] = callees
    return graph


def find_root(graph: Mapping[str, set[str]]) -> str:
    """The common ancestor; else the last function without callers that calls something; else the last."""
    if not graph:
        raise ProgramError("no registered function")

    def reach(start: str) -> set[str]:
        seen, pending = {start}, [start]
        while pending:
            new = graph[pending.pop()] - seen
            seen |= new
            pending += new
        return seen

    for name in graph:
        if len(reach(name)) == len(graph) and (len(graph) > 1):
            return name
    called = {callee for name, callees in graph.items() for callee in callees if callee != name}
    tops = [name for name, callees in graph.items() if name not in called and callees - {name}]
    return tops[-1] if tops else list(graph)[-1]


# --- flattening ---------------------------------------------------------------------------------------------------


def _plain(primitive: Mapping[str, Any]) -> dict[str, Any]:
    """A primitive as golden files write it."""
    matrix = np.array(primitive["matrix"], float)
    if primitive["shape"] == "block":
        matrix[:3] = np.trunc(matrix[:3])
    found = {**primitive, "matrix": _rounded(matrix.tolist())}
    for key in ("radius", "p0", "p1", "color"):
        if key in found:
            found[key] = _rounded(found[key])
    return found


def _rounded(value: Any) -> Any:
    if isinstance(value, list):
        return [_rounded(x) for x in value]
    return round(float(value), DIGITS) + 0.0


def _seed() -> None:
    np.random.seed(0)
    random.seed(0)


@contextlib.contextmanager
def _helper_modules(names: Mapping[str, Any]) -> Iterator[None]:
    saved = {alias: sys.modules.get(alias) for alias in ALIASES}
    state, numpy_state = random.getstate(), np.random.get_state()
    try:
        for alias in ALIASES:
            module = types.ModuleType(alias)
            module.__dict__.update(names)
            sys.modules[alias] = module
        yield
    finally:
        random.setstate(state)
        np.random.set_state(numpy_state)
        for alias, previous in saved.items():
            if previous is None:
                del sys.modules[alias]
            else:
                sys.modules[alias] = previous


def flatten(
    code: str,
    *,
    max_frames: int = 1000,
    output: io.StringIO | None = None,
    call: tuple[str, Mapping[str, Any]] | None = None,
) -> dict[str, Any]:
    """The golden structure of a program's text; what the program prints goes to `output`.

    `call` is a registered function with arguments, in place of the root.
    """
    run = Run()
    name = "scene_program"
    module = types.ModuleType(name)  # a dataclass looks its module up
    module.__dict__.update(run.names())
    tree = ast.parse(code)
    with (
        _helper_modules(run.names()),
        contextlib.redirect_stdout(output or io.StringIO()),
        warnings.catch_warnings(),
        np.errstate(all="ignore"),
    ):
        warnings.simplefilter("ignore")
        sys.modules[name] = module
        try:
            _seed()
            exec(compile(code, "<program>", "exec", dont_inherit=True), module.__dict__)
            if call is not None:
                root = call[0]
                _seed()
                shapes = [_as_shape(run.library[root][0](**call[1]))]
            elif run.animation is not None:
                root, generator = run.animation
                _seed()
                shapes = []
                for shape in generator():
                    shapes.append(_as_shape(shape))
                    if len(shapes) > max_frames:
                        raise ProgramError("too many frames")
            else:
                root = find_root(call_graph(run, tree))
                _seed()
                shapes = [_as_shape(run.library[root][0]())]
        finally:
            del sys.modules[name]
    blocks = any(p["shape"] == "block" for shape in shapes for p in shape)
    kind = "4d" if run.animation is not None else "minecraft" if blocks else "3d"
    frames = [{"primitives": [_plain(p) for p in shape]} for shape in shapes]
    return {"kind": kind, "root": root, "seed": 0, "frames": frames}


def load_golden(folder: Path, name: str) -> dict[str, Any]:
    """The golden file of that name, compressed or not."""
    packed = folder / f"{name}.json.gz"
    if packed.exists():
        return json.loads(gzip.decompress(packed.read_bytes()))
    return json.loads((folder / f"{name}.json").read_text())
