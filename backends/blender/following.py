"""Follows a script of `bpy` by evaluating it, with Blender's modules as objects of the evaluator.

Nothing is executed.
"""

from __future__ import annotations

import ast
import random
import re
from dataclasses import dataclass
from typing import Any

import numpy as np

from scenelang.backends.blender import modifiers
from scenelang.backends.blender.blend_model import (
    Blend,
    BlendContext,
    CollectionBlock,
    Data,
    Material,
    MeshBlock,
    Object,
    SceneBlock,
    ScriptCall,
    Settings,
)
from scenelang.backends.blender.bmeshes import bmesh_module
from scenelang.backends.blender.bpy_operators import OperatorRoot, Operators
from scenelang.backends.blender.vectors import mathutils_module
from scenelang.grammar.datum import Source, Span
from scenelang.grammar.diagnostics import Diagnostic, SceneError
from scenelang.interpreter.transpile.analysis.python_text import PythonText, parse_python
from scenelang.interpreter.transpile.evaluation import UnsupportedPython, words
from scenelang.interpreter.transpile.evaluation.classes import bound_arguments, limited_draw
from scenelang.interpreter.transpile.evaluation.evaluator import PythonEvaluator
from scenelang.interpreter.transpile.evaluation.library import PythonLibrary
from scenelang.interpreter.transpile.evaluation.objects import (
    Exhausted,
    Module,
    Native,
    PythonClass,
    PythonFunction,
    type_name,
    value_of_error,
)

_DRAWS = words(
    "betavariate choice choices expovariate gauss normalvariate paretovariate randint random randrange sample seed "
    "shuffle triangular uniform vonmisesvariate weibullvariate lognormvariate gammavariate getrandbits"
)
_ARRAY_DRAWS = words(
    "choice exponential normal permutation rand randint randn random random_sample seed shuffle standard_normal "
    "uniform poisson beta gamma binomial"
)
_SELECTS = re.compile(r"\b(?:random|enumerate|noise|index)\b|(?:vert\w*|faces|polygons)\[")
_BASES = ("Operator", "Panel", "PropertyGroup", "Menu", "Header", "UIList", "AddonPreferences")


@dataclass(frozen=True, slots=True)
class Followed:
    """State of Blender at the end of a script, and the warnings on the way."""

    blend: Blend
    text: PythonText
    warnings: tuple[Diagnostic, ...]


class ScriptEvaluator(PythonEvaluator):
    """Evaluator that tells which calls of the script's functions an object is made in."""

    def __init__(self, blend: Blend) -> None:
        super().__init__({}, {})
        self.blend = blend

    def _call_function(self, function: PythonFunction, arguments: tuple[Any, ...], named: dict[str, Any]) -> Any:
        if isinstance(function.node, ast.Lambda):
            return super()._call_function(function, arguments, named)
        given = bound_arguments(function, arguments, named)
        self.blend.calls.append(ScriptCall(function.name, self.blend.counted(), given))
        try:
            return super()._call_function(function, arguments, named)
        finally:
            self.blend.calls.pop()


def followed(source: Source) -> Followed:
    """Follow a script, or the one in a response. Raises SceneError with the place of what is not supported."""
    text = parse_python(source)
    if text.diagnostics:
        problem = text.diagnostics[0]
        raise SceneError(problem.name, problem.message, problem.hint, problem.span)
    blend = Blend()
    blend.selects_by_number = _SELECTS.search(source.text) is not None
    evaluator = blend.evaluator = ScriptEvaluator(blend)
    _provide(evaluator, blend)
    try:
        for statement in text.tree.body:
            evaluator.run(statement)
        blend.update(is_full=True)
    except SceneError:
        raise
    except RecursionError:
        raise
    except UnsupportedPython as error:
        span = text.span(error.node) if error.node is not None else _whole(text)
        name = "blender-unsupported" if error.name == "python-unsupported" else error.name
        raise SceneError(name, error.message, error.hint, span) from None
    except Exception as error:
        seen = value_of_error(error)
        node = evaluator.failed or evaluator.node
        kind, message = type_name(seen), "" if isinstance(error, Exhausted) else str(seen)
        span = text.span(node) if node is not None else _whole(text)
        raise SceneError(
            "python-exception", f"Python: {kind}: {message}" if message else f"Python: {kind}", None, span
        ) from None
    warnings = [
        Diagnostic("blender-ignored", message, text.span(node) if node is not None else _whole(text))
        for message, node in blend.warnings.items()
    ]
    return Followed(blend, text, tuple(warnings))


def _whole(text: PythonText) -> Span:
    return Span(text.source, text.response.start, text.response.start)


def _provide(evaluator: ScriptEvaluator, blend: Blend) -> None:
    """Give the evaluator its builtins and modules."""
    library = PythonLibrary(evaluator)
    modules = dict(library.modules)
    blend.modifier_defaults = modifiers.DEFAULTS
    blend.apply_modifiers = modifiers.evaluated
    bpy = _bpy(evaluator, blend)
    modules["bpy"], modules["mathutils"], modules["bmesh"] = bpy, mathutils_module(), bmesh_module(blend)
    for name in ("types", "props", "utils", "path", "app", "ops", "context", "data"):
        value = bpy.names[name]
        if isinstance(value, Module):
            modules[f"bpy.{name}"] = value
    modules["bmesh.ops"], modules["bmesh.types"] = Module("bmesh.ops", {}), modules["bmesh"].names["types"]
    modules["mathutils.noise"] = Module("mathutils.noise", {})
    modules["bpy_extras"] = Module("bpy_extras", {})
    modules["time"] = Module("time", {name: Native(name, lambda *_: 0.0) for name in ("time", "perf_counter", "sleep")})
    modules["os"] = Module("os", {"path": _paths()})
    modules["os.path"] = modules["os"].names["path"]
    modules["sys"] = Module("sys", {"argv": ["blender"], "path": []})
    modules["warnings"] = Module("warnings", {"filterwarnings": Native("filterwarnings", lambda *_, **__: None)})
    _add_draws(modules, blend)
    library.modules = evaluator.modules = modules
    evaluator.builtins = {**library.builtins, "print": Native("print", lambda *_, **__: None)}
    evaluator.module.names["__name__"] = "__main__"
    evaluator.module.names["__file__"] = "script.py"


def _paths() -> Module:
    def join(*parts: str) -> str:
        return "/".join(parts)

    return Module(
        "os.path",
        {
            "join": Native("join", join),
            "exists": Native("exists", lambda path: False),
            "isfile": Native("isfile", lambda path: False),
            "isdir": Native("isdir", lambda path: False),
            "expanduser": Native("expanduser", lambda path: path),
            "abspath": Native("abspath", lambda path: path),
            "dirname": Native("dirname", lambda path: path.rpartition("/")[0]),
            "basename": Native("basename", lambda path: path.rpartition("/")[2]),
        },
    )


def _add_draws(modules: dict[str, Any], blend: Blend) -> None:
    """Add the functions of `random` and `numpy.random`, of the seed 0 until the script gives another."""
    stream, array_stream = random.Random(0), np.random.RandomState(0)  # nosec B311 - as the script draws

    def drawn(name: str, owner: Any, seeded: list[bool]) -> Native:
        draw = limited_draw(name, getattr(owner, name))

        def call(*arguments: Any, **named: Any) -> Any:
            if name == "seed":
                seeded[0] = True
            elif not seeded[0]:
                seeded[0] = True
                blend.warn("the script draws random numbers without a seed: they are those of the seed 0")
            return draw(*arguments, **named)

        return Native(f"random.{name}", call)

    plain, arrays = [False], [False]
    names = {name: drawn(name, stream, plain) for name in _DRAWS}
    modules["random"] = Module("random", {**modules["random"].names, **names})
    numpy = modules["numpy"]
    draws = {name: drawn(name, array_stream, arrays) for name in _ARRAY_DRAWS}
    numpy.names["random"] = Module("np.random", {**numpy.names["random"].names, **draws})
    modules["numpy.random"] = numpy.names["random"]


def _bpy(evaluator: ScriptEvaluator, blend: Blend) -> Module:
    """Return the module `bpy`."""
    kinds: dict[str, Any] = {
        "Object": Object, "Mesh": MeshBlock, "Material": Material, "Collection": CollectionBlock, "Scene": SceneBlock,
        "Context": BlendContext, "BlendData": Data,
    }  # fmt: skip
    types: dict[str, Any] = {name: Native(f"bpy.types.{name}", _no_call, kind) for name, kind in kinds.items()}
    for name in _BASES:
        base = PythonClass(name, {}, (object,), evaluator)
        base.order = (base, object)
        types[name] = base
    props = {
        f"{kind}Property": Native(f"bpy.props.{kind}Property", lambda **named: named.get("default"))
        for kind in ("Float", "Int", "Bool", "String", "Enum", "FloatVector", "IntVector", "Pointer", "Collection")
    }
    nothing = lambda *_, **__: None
    utils = {name: Native(f"bpy.utils.{name}", nothing) for name in ("register_class", "unregister_class")}
    app = {
        "version": (5, 0, 1), "version_string": "5.0.1", "background": True, "handlers": _Handlers(),
        "timers": Settings(), "driver_namespace": {}, "binary_path": "",
    }  # fmt: skip
    path = {"abspath": Native("bpy.path.abspath", lambda text, **_: text.removeprefix("//"))}
    return Module(
        "bpy",
        {
            "data": blend.data,
            "context": blend.context,
            "ops": OperatorRoot(Operators(blend)),
            "types": Module("bpy.types", _Names(types)),
            "props": Module("bpy.props", props),
            "utils": Module("bpy.utils", utils),
            "app": Module("bpy.app", app),
            "path": Module("bpy.path", path),
        },
    )


class _Names(dict[str, Any]):
    """Names of `bpy.types`: those that are not known stand for types of which nothing is an instance."""

    def get(self, name: str, default: Any = None) -> Any:
        if name not in self and name[:1].isupper():
            self[name] = Native(f"bpy.types.{name}", _no_call, type(name, (), {}))
        return super().get(name, default)


class _Handlers(Settings):
    """`bpy.app.handlers`: functions that Blender calls at every frame, which cannot be followed."""

    def read(self, name: str) -> Any:
        if name == "persistent":
            return Native("persistent", lambda function: function)
        return _HandlerList(name)


class _HandlerList(Settings):
    def __init__(self, name: str) -> None:
        super().__init__()
        self._name = name

    def read(self, name: str) -> Any:
        def add(*_: Any) -> None:
            if self._name.startswith(("frame_change", "depsgraph")):
                raise UnsupportedPython(
                    f"functions that Blender calls (`{self._name}`) are not supported", "use keyframes"
                )

        return Native(name, add)


def _no_call(*_: Any, **__: Any) -> Any:
    raise TypeError("bpy_struct.__new__(type): expected a single argument")
