"""Builtins and modules of the evaluator of Python: what programs may call."""

from __future__ import annotations

import ast
import bisect
import builtins
import cmath
import collections
import collections.abc
import colorsys
import fractions
import functools
import hashlib
import heapq
import itertools
import json
import math
import operator
import random
import re
import statistics
import string
import textwrap
import zlib
from collections.abc import Callable, Iterable, Iterator
from typing import Any

import numpy as np

from scenelang.interpreter.transpile.analysis.library_rotations import MODULE as ROTATION_MODULE
from scenelang.interpreter.transpile.analysis.library_rotations import ROTATION, STACKS
from scenelang.interpreter.transpile.evaluation import (
    CREATORS,
    LINALG,
    MAX_BITS,
    MAX_ITEMS,
    NUMPY,
    NUMPY_TYPES,
    PRODUCTS,
    UNSAFE,
    UnsupportedPython,
    check_repetitions,
    check_size,
    few,
    instead_of,
    product_of,
    repeats_choices,
    words,
)
from scenelang.interpreter.transpile.evaluation.classes import (
    AUTO,
    ENUMERATIONS,
    attribute_of,
    create,
    host_type,
    is_instance,
    make_dataclass,
    mapping_of,
    named_tuple,
    set_attribute,
    shallow_copy,
    type_named,
    type_of,
)
from scenelang.interpreter.transpile.evaluation.deterministic import is_deterministic
from scenelang.interpreter.transpile.evaluation.evaluator import PythonEvaluator
from scenelang.interpreter.transpile.evaluation.modules import plain_modules, silent_modules
from scenelang.interpreter.transpile.evaluation.noise import NOISE, noise_names
from scenelang.interpreter.transpile.evaluation.objects import (
    MISSING,
    BoundMethod,
    Cache,
    ClassMethod,
    DataField,
    Frame,
    Module,
    NamedTuple,
    Native,
    Property,
    PythonClass,
    PythonFunction,
    PythonGenerator,
    PythonObject,
    Raised,
    StaticMethod,
    Super,
    ValueObject,
    delete_attribute,
    linearized,
    refused,
)
from scenelang.interpreter.transpile.evaluation.residue import Residual, formatted, is_shape
from scenelang.interpreter.transpile.evaluation.scientific import FUNCTIONS, library_names


class PythonLibrary:
    """Builtins and modules for one evaluator, which calls functions of the program."""

    def __init__(self, evaluator: PythonEvaluator) -> None:
        self.evaluator = evaluator
        modules = {
            "math": _public("math", math, numeric=True), "cmath": _public("cmath", cmath),
            "itertools": _public("itertools", itertools), "heapq": _public("heapq", heapq),
            "bisect": _public("bisect", bisect), "statistics": _public("statistics", statistics),
            "colorsys": _public("colorsys", colorsys), "operator": _operators(evaluator),
            "collections": self._collections(), "functools": self._functools(), "enum": self._enum(),
            "dataclasses": self._dataclasses(), "typing": self._typing(), "abc": self._abc(),
            "contextlib": self._contextlib(), "copy": self._copy(), "re": _patterns(), "string": _strings(),
            "textwrap": _limited_texts(_only("textwrap", textwrap, "dedent fill indent shorten wrap")),
            "fractions": {"Fraction": Native("fractions.Fraction", _fraction, fractions.Fraction)},
            "hashlib": _hashes(), "zlib": _only("zlib", zlib, "adler32 crc32"),
            "json": {"loads": Native("json.loads", json.loads), "dumps": Native("json.dumps", few(json.dumps))},
            "numbers": {}, "types": self._types(), "__future__": {},
            **plain_modules(), **silent_modules(),
        }  # fmt: skip
        modules["itertools"]["chain"] = _kind("itertools.chain", itertools.chain)
        for name in ("product", "tee"):
            modules["itertools"][name] = Native(f"itertools.{name}", few(getattr(itertools, name)))
        modules["itertools"]["batched"] = Native("itertools.batched", _batched)
        modules["collections.abc"] = modules["typing"]
        modules["typing_extensions"] = modules["typing"]
        self.modules = {path: Module(path, names) for path, names in modules.items()}
        self.modules["random"] = Module("random", {"Random": _kind("random.Random", random.Random)})
        self.modules["numpy"] = self.modules["np"] = Module("np", numpy_names(evaluator))
        for path in ("linalg", "random"):
            self.modules[f"numpy.{path}"] = self.modules["numpy"].names[path]
        self._loaders: dict[str, Callable[[], dict[str, Any]]] = {
            **{path: functools.partial(library_names, path) for path in FUNCTIONS},
            **{path: functools.partial(noise_names, path) for path in NOISE},
            ROTATION_MODULE: lambda: _rotations(evaluator),
        }
        self._packages = {path[:end] for path in self._loaders for end in range(len(path)) if path[end] == "."}
        self.builtins = self._builtins()
        evaluator.mixin = functools.partial(_mixin, evaluator)
        evaluator.module_of = self.module_of

    def module_of(self, path: str) -> Any:
        """Return a module, or what is an error when it is used."""
        if path in self._loaders or path in self._packages:
            if path not in self.modules:
                try:
                    names = self._loaders.get(path, dict)()
                except UnsupportedPython as error:  # without the extra
                    return refused(error)
                self.modules[path] = Module(path, _Names(path, names, self._submodule))
        if path in self.modules:
            return self.modules[path]
        top = path.partition(".")[0]
        kind = "python-forbidden" if top in UNSAFE else "python-unsupported"
        return refused(UnsupportedPython(f"the module `{path}` cannot be used", instead_of(top), kind))

    def _submodule(self, path: str) -> Any:
        return self.module_of(path) if path in self._loaders or path in self._packages else MISSING

    # --- builtins ----------------------------------------------------------------------------------------------

    def _builtins(self) -> dict[str, Any]:
        types: dict[str, Any] = {
            "int": int, "float": float, "str": str, "bool": bool, "complex": complex, "list": list, "tuple": tuple,
            "set": set, "frozenset": frozenset, "range": range, "object": object,
            "slice": slice,
        }  # fmt: skip
        names: dict[str, Any] = {
            name: _kind(name, kind, is_numeric=name in ("int", "float")) for name, kind in types.items()
        }
        names["object"] = Native("object", lambda: PythonObject(PythonClass("object", {}, (), self.evaluator)), object)
        names["list"] = Native("list", self._list, list)
        names["dict"] = Native("dict", self._dict, dict)
        for name, kind in (("bytes", bytes), ("bytearray", bytearray)):
            names[name] = Native(name, _limited_bytes(kind), kind)
        names["delattr"] = Native("delattr", functools.partial(delete_attribute, self.evaluator))
        names["sum"] = Native("sum", _sum)
        for name in ("abs", "round", "divmod", "pow", "min", "max"):
            names[name] = Native(name, getattr(builtins, name), None, True)
        names["pow"] = Native("pow", self._pow, None, True)
        look = self.evaluator.look
        names["enumerate"] = Native("enumerate", lambda items, start=0: enumerate(look(items), start))
        names["reversed"] = Native("reversed", lambda items: reversed(look(items)))
        count = lambda value: len(value.parts()) if type(value) is Residual else len(look(value))
        names["len"] = Native("len", count)
        for name in words("all any ascii bin chr filter hash hex iter map next oct ord repr sorted zip"):
            names[name] = Native(name, getattr(builtins, name))
        for name, value in vars(builtins).items():
            if isinstance(value, type) and issubclass(value, Exception):
                names[name] = Native(name, value, value)
        special: dict[str, Callable[..., Any]] = {
            "isinstance": functools.partial(is_instance, self.evaluator), "issubclass": self._is_subclass,
            "callable": _is_callable,
            "getattr": self._getattr, "hasattr": self._hasattr, "setattr": self._setattr,
            "id": id, "vars": self._vars, "format": self._format,
            "super": Super, "input": self._unsafe("input"), "open": self._unsafe("open"), "eval": self._unsafe("eval"),
            "exec": self._unsafe("exec"), "compile": self._unsafe("compile"), "__import__": self._unsafe("__import__"),
            "globals": self._unsafe("globals"), "locals": self._unsafe("locals"),
            "breakpoint": self._unsafe("breakpoint"), "dir": self._unsafe("dir"),
        }  # fmt: skip
        names |= {name: Native(name, function) for name, function in special.items()}
        names["type"] = Native("type", self._type, type)
        names["property"] = Native("property", Property)
        names["staticmethod"] = Native("staticmethod", StaticMethod)
        names["classmethod"] = Native("classmethod", ClassMethod)
        names["NotImplemented"], names["Ellipsis"], names["__debug__"] = NotImplemented, ..., True
        return names

    def _unsafe(self, name: str) -> Callable[..., Any]:
        def refuse(*arguments: Any, **named: Any) -> Any:
            raise UnsupportedPython(f"`{name}` is not allowed", instead_of(name), "python-forbidden")

        return refuse

    def _pow(self, base: Any, exponent: Any, modulus: Any = None) -> Any:
        if isinstance(base, int) and isinstance(exponent, int) and modulus is None:
            if base.bit_length() * abs(exponent) > MAX_BITS:
                raise UnsupportedPython("this number has too many digits")
        return pow(base, exponent) if modulus is None else pow(base, exponent, modulus)

    def _is_subclass(self, cls: Any, other: Any) -> bool:
        if isinstance(other, tuple):
            return any(self._is_subclass(cls, each) for each in other)
        kind = host_type(other)
        return bool(cls.is_subclass(kind)) if type(cls) is PythonClass else issubclass(host_type(cls), kind)

    def _type(self, value: Any, *rest: Any) -> Any:
        if rest:
            raise UnsupportedPython("`type` with three arguments is not supported", "write a `class` statement")
        return type_of(self.evaluator, value)

    def _getattr(self, value: Any, name: str, default: Any = UnsupportedPython) -> Any:
        try:
            return attribute_of(self.evaluator, value, name, default)
        except AttributeError:  # of the program's own methods
            if default is UnsupportedPython:
                raise
            return default
        except Raised as error:
            if default is UnsupportedPython or not error.value.cls.is_subclass(AttributeError):
                raise
            return default

    def _hasattr(self, value: Any, name: str) -> bool:
        return self._getattr(value, name, MISSING) is not MISSING

    def _list(self, items: Any = ()) -> list[Any]:
        return self.evaluator.spread(items) if is_shape(items) else list(items)

    def _dict(self, *items: Any, **named: Any) -> dict[Any, Any]:
        return dict(*(mapping_of(self.evaluator, each) for each in items), **named)

    def _setattr(self, value: Any, name: str, new: Any) -> None:
        set_attribute(self.evaluator, value, name, new)

    def _vars(self, value: Any) -> Any:
        if type(value) is not PythonObject:
            raise UnsupportedPython("`vars` is supported for the program's own objects only")
        return value.fields

    def _format(self, value: Any, specification: str = "") -> str:
        return formatted(value, specification)

    # --- modules -----------------------------------------------------------------------------------------------

    def _collections(self) -> dict[str, Any]:
        kinds = {
            name: getattr(collections, name) for name in ["Counter", "OrderedDict", "defaultdict", "deque", "ChainMap"]
        }
        names: dict[str, Any] = {name: _kind(f"collections.{name}", kind) for name, kind in kinds.items()}
        names |= {name: Native(f"collections.{name}", _no_call, object) for name in ("UserDict", "UserList")}
        names["namedtuple"] = Native(
            "collections.namedtuple",
            lambda name, fields, defaults=(), **_: named_tuple(self.evaluator, name, fields, defaults),
        )
        return names

    def _functools(self) -> dict[str, Any]:
        call = self.evaluator.call

        def partial(function: Any, *first: Any, **fixed: Any) -> Any:
            made = Native(
                "functools.partial", lambda *rest, **named: call(function, (*first, *rest), {**fixed, **named})
            )
            made.attributes = {"func": function, "args": first, "keywords": fixed}
            return made

        def cached(function: Any) -> Any:
            known, calls = Cache(), Cache(count=0)

            def look(*arguments: Any, **named: Any) -> Any:
                calls["count"] += 1
                key = (arguments, tuple(named.items()))
                if key not in known:
                    known[key] = call(function, arguments, named)
                return known[key]

            kind = named_tuple(self.evaluator, "CacheInfo", "hits misses maxsize currsize")
            info = lambda: create(self.evaluator, kind, (calls["count"] - len(known), len(known), None, len(known)), {})
            made = Native(getattr(function, "name", "cached"), look)
            made.attributes = {
                "is_method": True, "cache_clear": Native("cache_clear", known.clear),
                "cache_info": Native("cache_info", info), "__wrapped__": function,
            }  # fmt: skip
            return made

        def lru_cache(maxsize: Any = 128, typed: bool = False) -> Any:
            is_function = type(maxsize) not in (int, type(None))
            return cached(maxsize) if is_function else Native("functools.lru_cache", cached)

        def wraps(wrapped: Any, *_: Any, **__: Any) -> Any:
            def mark(function: Any) -> Any:
                if type(function) is PythonFunction:
                    function.name = getattr(wrapped, "name", function.name)
                    function.attributes |= {**getattr(wrapped, "attributes", {}), "__wrapped__": wrapped}
                return function

            return Native("functools.wraps", mark)

        def partial_method(function: Any, *first: Any, **fixed: Any) -> Any:
            bound = lambda value, *rest, **named: call(function, (value, *first, *rest), {**fixed, **named})
            return Native("functools.partialmethod", bound, attributes={"is_method": True})

        def single(function: Any, place: int = 0) -> Any:
            kinds: list[tuple[Any, Any]] = []

            def dispatch(*values: Any, **named: Any) -> Any:
                value = values[place]
                fitting = [(kind, each) for kind, each in kinds if is_instance(self.evaluator, value, kind)]
                best = max(fitting, key=lambda pair: _specificity(pair[0], value), default=(None, function))
                return call(best[1], values, named)

            def register(kind: Any, target: Any = None) -> Any:
                if type(kind) is PythonFunction:  # by the annotation of the first parameter
                    first = kind.node.args.args[place].annotation
                    kinds.append((self.evaluator.eval(first, kind.outer), kind))  # type: ignore[arg-type]
                    return kind
                if target is not None:
                    kinds.append((kind, target))
                    return target

                def add(each: Any) -> Any:
                    kinds.append((kind, each))
                    return each

                return Native("register", add)

            made = Native(getattr(function, "name", ""), dispatch)
            made.attributes = {"register": Native("register", register), "is_method": True}
            return made

        return {
            "partial": Native("functools.partial", partial), "reduce": Native("functools.reduce", functools.reduce),
            "lru_cache": Native("functools.lru_cache", lru_cache), "cache": Native("functools.cache", cached),
            "wraps": Native("functools.wraps", wraps), "total_ordering": Native("functools.total_ordering", _total),
            "cached_property": Native("functools.cached_property", lambda f: Property(f, is_cached=True)),
            "singledispatch": Native("functools.singledispatch", single),
            "singledispatchmethod": Native("functools.singledispatchmethod", lambda function: single(function, 1)),
            "partialmethod": Native("functools.partialmethod", partial_method),
            "cmp_to_key": Native("functools.cmp_to_key", functools.cmp_to_key),
        }  # fmt: skip

    def _enum(self) -> dict[str, Any]:
        names: dict[str, Any] = {name: Native(f"enum.{name}", _no_call, object) for name in ENUMERATIONS}
        names["auto"] = Native("enum.auto", lambda: PythonObject(AUTO))
        names["unique"] = Native("enum.unique", lambda cls: cls)
        return names

    def _dataclasses(self) -> dict[str, Any]:
        evaluator = self.evaluator

        def dataclass(cls: Any = None, **options: Any) -> Any:
            if cls is not None:
                return make_dataclass(evaluator, cls, options)
            return Native("dataclass", lambda each: make_dataclass(evaluator, each, options))

        def field(
            default: Any = MISSING, default_factory: Any = MISSING, init: bool = True, repr: bool = True,
            compare: bool = True, kw_only: bool = False, **_: Any,
        ) -> DataField:  # fmt: skip
            return DataField("", default, default_factory, init, repr, compare, kw_only)

        def replace(value: Any, **new: Any) -> Any:
            own = {each.name: value.fields[each.name] for each in value.cls.data if each.in_init}
            return create(evaluator, value.cls, (), {**own, **new})

        def as_dict(value: Any) -> Any:
            return _plain(value, lambda each: {f.name: as_dict(each.fields[f.name]) for f in each.cls.data})

        def as_tuple(value: Any) -> Any:
            return _plain(value, lambda each: tuple(as_tuple(each.fields[f.name]) for f in each.cls.data))

        def fields(value: Any) -> Any:
            cls = value if type(value) is PythonClass else value.cls
            kind = PythonClass("Field", {}, (object,), evaluator)
            kind.order = (kind, object)
            return tuple(PythonObject(kind, {"name": each.name, "default": each.default}) for each in cls.data or ())

        functions: dict[str, Callable[..., Any]] = {
            "dataclass": dataclass, "field": field, "replace": replace, "asdict": as_dict, "astuple": as_tuple,
            "fields": fields, "is_dataclass": _is_dataclass,
        }  # fmt: skip
        names: dict[str, Any] = {name: Native(f"dataclasses.{name}", function) for name, function in functions.items()}
        names |= {name: Native(f"dataclasses.{name}", _no_call, object) for name in ("InitVar", "KW_ONLY")}
        names["FrozenInstanceError"] = Native("FrozenInstanceError", AttributeError, AttributeError)
        return names

    def _typing(self) -> dict[str, Any]:
        names: dict[str, Any] = {}
        for name in _TYPING:
            kind = getattr(collections.abc, name, None)
            names[name] = Native(f"typing.{name}", _no_call, kind if isinstance(kind, type) else object)
        names["Callable"] = Native("typing.Callable", _no_call, Callable)
        names |= {name: Native(f"typing.{name}", _no_call, kind) for name, kind in _GENERIC.items()}
        for name in ("overload", "final", "runtime_checkable", "no_type_check", "override"):
            names[name] = Native(f"typing.{name}", lambda each: each)
        names["cast"] = Native("typing.cast", lambda kind, value: value)
        for name in ("TypeVar", "NewType", "ParamSpec"):
            names[name] = Native(
                f"typing.{name}", lambda *rest, **named: Native("typing.Any", lambda value: value, object)
            )
        names["TYPE_CHECKING"] = False
        names["get_args"] = Native("typing.get_args", lambda kind: ())
        return names

    def _abc(self) -> dict[str, Any]:
        def abstract(function: Any) -> Any:
            inner = function.get if type(function) is Property else getattr(function, "function", function)
            if type(inner) is PythonFunction:
                inner.attributes["is_abstract"] = True
            return function

        return {
            "ABC": Native("abc.ABC", _no_call, object), "ABCMeta": Native("abc.ABCMeta", _no_call, object),
            "abstractmethod": Native("abc.abstractmethod", abstract),
            "abstractproperty": Native("abc.abstractproperty", lambda function: Property(abstract(function))),
        }  # fmt: skip

    def _contextlib(self) -> dict[str, Any]:
        """Return the supported names of ``contextlib``."""
        evaluator = self.evaluator

        def manager(function: Any) -> Any:
            """Return a function that makes a context manager from a generator function."""

            def make(*arguments: Any, **named: Any) -> Any:
                generator: PythonGenerator = evaluator.call(function, arguments, named)

                def leave(kind: Any, value: Any, trace: Any) -> bool:
                    if value is None:
                        next(generator, None)
                        return False
                    error = Raised(value) if type(value) is PythonObject else value
                    try:
                        generator.steps.throw(error)
                    except StopIteration:
                        return True
                    except Exception as raised:
                        # the same error again means that the generator has not handled it
                        if raised is not error:
                            raise
                    return False

                return _manager(evaluator, lambda: next(generator), leave)

            return Native(getattr(function, "name", "manager"), make, attributes={"is_method": True})

        def suppress(*kinds: Any) -> Any:
            def leave(kind: Any, value: Any, trace: Any) -> bool:
                return value is not None and is_instance(evaluator, value, kinds)

            return _manager(evaluator, lambda: None, leave)

        return {
            "contextmanager": Native("contextlib.contextmanager", manager),
            "suppress": Native("contextlib.suppress", suppress),
            "ExitStack": Native("contextlib.ExitStack", self._exit_stack),
            "nullcontext": Native(
                "contextlib.nullcontext", lambda v=None: _manager(evaluator, lambda: v, lambda *_: False)
            ),
        }

    def _exit_stack(self) -> PythonObject:
        """Return a context manager that leaves others in reverse order, like ``contextlib.ExitStack``."""
        evaluator = self.evaluator
        leaves: list[Callable[..., Any]] = []

        def enter(manager: Any) -> Any:
            value = evaluator.call(attribute_of(evaluator, manager, "__enter__", UnsupportedPython), (), {})
            leave = attribute_of(evaluator, manager, "__exit__", UnsupportedPython)
            leaves.append(lambda *error: evaluator.call(leave, error, {}))
            return value

        def add(function: Any, *rest: Any, **named: Any) -> None:
            # a callback cannot suppress an error
            leaves.append(lambda *error: evaluator.call(function, rest, named) and False)

        def leave(*error: Any) -> bool:
            results = [bool(each(*error)) for each in reversed(leaves)]
            return any(results)

        stack = _manager(evaluator, lambda: stack, leave)
        stack.fields |= {"enter_context": Native("enter_context", enter), "callback": Native("callback", add)}
        stack.fields["close"] = Native("close", lambda: leave(None, None, None))
        return stack

    def _copy(self) -> dict[str, Any]:
        return {"copy": Native("copy.copy", shallow_copy), "deepcopy": Native("copy.deepcopy", deep_copy)}

    def _types(self) -> dict[str, Any]:
        kinds: dict[str, type] = {
            "FunctionType": PythonFunction, "LambdaType": PythonFunction, "MethodType": BoundMethod,
            "GeneratorType": PythonGenerator, "NoneType": type(None), "ModuleType": Module,
        }  # fmt: skip

        def namespace(**fields: Any) -> PythonObject:
            shown = lambda value: f"namespace({', '.join(f'{k}={v!r}' for k, v in value.fields.items())})"
            cls = PythonClass("SimpleNamespace", {"__repr__": Native("__repr__", shown)}, (object,), self.evaluator)
            cls.options["eq"] = True
            cls.order = (cls, object)
            return PythonObject(cls, fields)

        return {
            "SimpleNamespace": Native("types.SimpleNamespace", namespace),
            "MappingProxyType": Native("types.MappingProxyType", dict),
            **{name: type_named(self.evaluator, kind) for name, kind in kinds.items()},
        }


class _Names(dict[str, Any]):
    """Names of a module, with those of its submodules, which are loaded when they are read."""

    def __init__(self, path: str, names: dict[str, Any], submodule: Callable[[str], Any]) -> None:
        super().__init__(names)
        self._path, self._submodule = path, submodule

    def get(self, name: str, default: Any = None) -> Any:
        member = self._submodule(f"{self._path}.{name}")
        return super().get(name, default) if member is MISSING else member


_TYPING = words(
    "Any Union Optional Literal Final ClassVar Annotated Generic Protocol NamedTuple TypedDict Iterable Iterator "
    "Generator Sequence Mapping MutableMapping MutableSequence Hashable Sized Container Collection Self Never "
    "NoReturn TypeAlias Concatenate Required NotRequired SupportsFloat SupportsInt Reversible Text AnyStr Number"
)
_GENERIC: dict[str, Any] = {
    "List": list, "Tuple": tuple, "Dict": dict, "Set": set, "FrozenSet": frozenset, "Type": type,
    "Deque": collections.deque, "DefaultDict": collections.defaultdict, "Counter": collections.Counter,
    "OrderedDict": collections.OrderedDict,
}  # fmt: skip


def _kind(path: str, kind: Any, *, is_numeric: bool = False) -> Native:
    return Native(path, kind, kind, is_numeric)


def _no_call(*arguments: Any, **named: Any) -> Any:
    raise UnsupportedPython("this type cannot be called")


def _public(path: str, module: Any, *, numeric: bool = False) -> dict[str, Any]:
    names: dict[str, Any] = {}
    for name, value in vars(module).items():
        if not name.startswith("_"):
            is_function = callable(value)
            names[name] = Native(f"{path}.{name}", value, None, numeric) if is_function else value
    if path == "math":
        names["prod"] = Native("math.prod", product_of, None, True)
        for name in ("factorial", "comb", "perm"):
            names[name] = Native(f"math.{name}", _small(getattr(math, name)), None)
    return {
        name: value
        for name, value in names.items()
        if type(value) is Native or isinstance(value, (int, float, complex))
    }


def _small(function: Callable[..., Any]) -> Callable[..., Any]:
    def limited(*numbers: Any) -> Any:
        if any(isinstance(each, int) and each > 2_000 for each in numbers):
            raise UnsupportedPython("this number has too many digits")
        return function(*numbers)

    return limited


def _only(path: str, module: Any, names: str) -> dict[str, Any]:
    return {name: Native(f"{path}.{name}", getattr(module, name)) for name in names.split()}


def _batched(items: Iterable[Any], count: int) -> Iterator[tuple[Any, ...]]:
    iterator = iter(items)
    while group := tuple(itertools.islice(iterator, count)):
        yield group


def _fraction(*given: Any) -> fractions.Fraction:
    if any(isinstance(each, str) and (len(each) > 100 or "e" in each.lower()) for each in given):
        raise UnsupportedPython("this text of a fraction is not supported", "write `Fraction(1, 3)`")
    return fractions.Fraction(*given)


def _limited_texts(names: dict[str, Any]) -> dict[str, Any]:
    def limited(function: Callable[..., Any]) -> Callable[..., Any]:
        def call(*arguments: Any, **named: Any) -> Any:
            if sum(len(each) for each in (*arguments, *named.values()) if isinstance(each, str)) > _MAX_SEARCHED_LENGTH:
                raise UnsupportedPython("this text is too long")
            return function(*arguments, **named)

        return call

    return {name: Native(native.path, limited(native.function)) for name, native in names.items()}


def _limited_bytes(kind: Any) -> Callable[..., Any]:
    def make(*arguments: Any, **named: Any) -> Any:
        if any(isinstance(each, int) and each > MAX_ITEMS for each in arguments):
            raise UnsupportedPython(f"this {kind.__name__} has more than {MAX_ITEMS:,} items")
        return kind(*arguments, **named)

    return make


def _sum(items: Any, start: Any = 0) -> Any:
    """Add values; lists of shapes may contain shapes that are added to lists."""
    total = start
    for item in items:
        total = total + ([item] if isinstance(total, list) and type(item) is Residual else item)
    return total


def _is_callable(value: Any) -> bool:
    if type(value) is PythonObject:
        return value.method("__call__") is not None
    return isinstance(value, (PythonFunction, BoundMethod, Native, PythonClass))


def _specificity(kind: Any, value: Any) -> int:
    order = value.cls.order if hasattr(value, "cls") else type(value).__mro__
    target = kind if type(kind) is PythonClass else kind.type
    return -next((i for i, each in enumerate(order) if each is target), len(order))


def _is_dataclass(value: Any) -> bool:
    return getattr(getattr(value, "cls", value), "data", None) is not None


def _total(cls: PythonClass) -> PythonClass:
    cls.is_total = True
    return cls


def _plain(value: Any, convert: Callable[[Any], Any]) -> Any:
    """Convert the instances of dataclasses inside a value."""
    if type(value) is PythonObject and value.cls.data is not None:
        return convert(value)
    if type(value) in (list, tuple):
        return type(value)(_plain(each, convert) for each in value)
    if type(value) is dict:
        return {key: _plain(each, convert) for key, each in value.items()}
    return value


def _manager(evaluator: PythonEvaluator, enter: Callable[[], Any], leave: Callable[..., bool]) -> PythonObject:
    """Create a context manager."""
    cls = PythonClass("ContextManager", {}, (object,), evaluator)
    cls.order = (cls, object)
    return PythonObject(cls, {"__enter__": Native("__enter__", enter), "__exit__": Native("__exit__", leave)})


def _operators(evaluator: PythonEvaluator) -> dict[str, Any]:
    """Return the functions of ``operator``; those that can give huge results are limited."""
    entries = _public("operator", operator)

    def get(value: Any, path: str) -> Any:
        for name in path.split("."):
            value = attribute_of(evaluator, value, name, UnsupportedPython)
        return value

    def attrgetter(*names: str) -> Native:
        def read(value: Any) -> Any:
            values = tuple(get(value, name) for name in names)
            return values[0] if len(names) == 1 else values

        return Native("operator.attrgetter", read)

    def methodcaller(name: str, *arguments: Any, **named: Any) -> Native:
        return Native("operator.methodcaller", lambda value: evaluator.call(get(value, name), arguments, named))

    def itemgetter(*indices: Any) -> Native:
        return Native("operator.itemgetter", operator.itemgetter(*indices))

    entries["attrgetter"], entries["methodcaller"] = Native("operator.attrgetter", attrgetter), Native("", methodcaller)
    entries["itemgetter"] = Native("operator.itemgetter", itemgetter)
    # the host's versions have no limit on the size of a result
    for name in ("pow", "ipow", "mul", "imul", "lshift", "ilshift", "repeat", "call"):
        entries.pop(name, None)
    for name, node in (("mul", ast.Mult()), ("pow", ast.Pow()), ("lshift", ast.LShift()), ("mod", ast.Mod())):
        entries[name] = Native(f"operator.{name}", _limited(evaluator, node, getattr(operator, name)))
    return entries


def _limited(evaluator: PythonEvaluator, node: ast.operator, function: Callable[[Any, Any], Any]) -> Callable[..., Any]:
    return lambda left, right: evaluator.operate(node, function, left, right)


_MAX_PATTERN_LENGTH, _MAX_SEARCHED_LENGTH = 200, 20_000  # characters: matching may backtrack
_NESTED = re.compile(r"[*+}]\)*[*+{]|\([^()]*[*+][^()]*\)[*+{]")  # patterns that may backtrack without end


def _patterns() -> dict[str, Any]:
    """Return the functions and flags of ``re``; patterns and texts that may take too long are refused."""

    def checked(function: Callable[..., Any]) -> Callable[..., Any]:
        def search(pattern: Any, *rest: Any, **named: Any) -> Any:
            text = pattern.pattern if isinstance(pattern, re.Pattern) else pattern
            may_go_back = _NESTED.search(text) or repeats_choices(text)
            flags = [each for each in (*rest, *named.values()) if isinstance(each, int) and each]  # or a count
            has_flags = flags or (isinstance(pattern, re.Pattern) and pattern.flags != re.UNICODE)
            if len(text) > _MAX_PATTERN_LENGTH or (may_go_back and (has_flags or not is_deterministic(text))):
                raise UnsupportedPython("this pattern may take too long to match", "use a simpler pattern")
            texts = [each for each in (*rest, *named.values()) if isinstance(each, str)]
            # the lengths multiply, since a replacement can be inserted at every character
            if (
                any(len(each) > _MAX_SEARCHED_LENGTH for each in texts)
                or math.prod(len(each) + 1 for each in texts) > 10**8
            ):
                raise UnsupportedPython("this text is too long to be searched")
            check_repetitions(text, max(map(len, texts), default=0))
            return function(pattern, *rest, **named)

        return search

    names = "compile escape findall finditer fullmatch match search split sub"
    entries: dict[str, Any] = {name: Native(f"re.{name}", checked(getattr(re, name))) for name in names.split()}
    entries |= {
        name: getattr(re, name) for name in ("IGNORECASE", "I", "MULTILINE", "M", "VERBOSE", "X", "DOTALL", "S")
    }
    entries["Match"], entries["Pattern"] = (
        Native("re.Match", _no_call, re.Match),
        Native("re.Pattern", _no_call, re.Pattern),
    )
    return entries


def _hashes() -> dict[str, Any]:
    kinds = ("md5", "sha1", "sha224", "sha256", "sha384", "sha512", "blake2b", "blake2s")
    return {kind: Native(f"hashlib.{kind}", functools.partial(_hash_of, kind)) for kind in kinds}


def _hash_of(kind: str, data: bytes = b"", **_: Any) -> Native:
    hasher = hashlib.new(kind, data, usedforsecurity=False)
    methods = {name: Native(name, getattr(hasher, name)) for name in ("digest", "hexdigest", "update")}
    return Native(f"hashlib.{kind}", _no_call, attributes=methods)


def _strings() -> dict[str, Any]:
    names: dict[str, Any] = {
        name: value for name, value in vars(string).items() if type(value) is str and name[0] != "_"
    }
    names["Template"] = _kind("string.Template", string.Template)
    names["capwords"] = Native("string.capwords", string.capwords)
    return names


def deep_copy(value: Any, memo: dict[int, Any] | None = None) -> Any:
    """Copy a value with all that it contains."""
    memo = {} if memo is None else memo
    if id(value) in memo:
        return memo[id(value)]
    if type(value) is PythonObject:
        made = memo[id(value)] = PythonObject(value.cls)
        made.fields = {name: deep_copy(each, memo) for name, each in value.fields.items()}
        return value if value.cls.members is not None else made
    if type(value) is NamedTuple:
        copied = NamedTuple(deep_copy(each, memo) for each in value)
        copied.cls, copied.fields = value.cls, {}
        return copied
    if isinstance(value, ValueObject):
        made = memo[id(value)] = shallow_copy(value)
        made.fields = {name: deep_copy(each, memo) for name, each in value.fields.items()}
        return made
    if type(value) is list:
        items: list[Any] = []
        memo[id(value)] = items
        items += [deep_copy(each, memo) for each in value]
        return items
    if isinstance(value, dict):
        copy_of = value.copy()
        copy_of.clear()
        memo[id(value)] = copy_of
        copy_of.update({deep_copy(key, memo): deep_copy(each, memo) for key, each in value.items()})
        return copy_of
    if type(value) in (tuple, set, collections.deque):
        return type(value)(deep_copy(each, memo) for each in value)
    return value.copy() if isinstance(value, np.ndarray) else value


# numpy.


def numpy_names(evaluator: PythonEvaluator) -> dict[str, Any]:
    """Return the names of numpy that programs may use."""
    names: dict[str, Any] = {}
    for name in NUMPY:
        function = getattr(np, name, None)
        if function is not None:
            names[name] = Native(f"np.{name}", _array_function(name, function), None, True)
    names |= {name: _kind(f"np.{name}", getattr(np, name)) for name in NUMPY_TYPES}
    names["ndarray"], names["float_"] = Native("np.ndarray", _no_call, np.ndarray), _kind("np.float64", np.float64)
    names["integer"], names["floating"] = Native("np.integer", _no_call, np.integer), Native("", _no_call, np.floating)
    names["number"], names["bool"] = Native("np.number", _no_call, np.number), _kind("np.bool_", np.bool_)
    for name in ("matmul", "dot"):  # of poses that are known when the program runs
        names[name] = Native(f"np.{name}", functools.partial(_product, getattr(np, name)), None, True)
    names["nditer"] = Native("np.nditer", _items_of_arrays)
    names |= {name: _Grid(getattr(np, name)) for name in ("c_", "mgrid", "ogrid", "r_")}
    names["array"] = Native("np.array", _array_function("array", np.array))
    names["asarray"] = Native("np.asarray", _array_function("asarray", np.asarray))
    names["vectorize"] = Native("np.vectorize", _vectorized)
    names |= {
        "pi": np.pi,
        "e": np.e,
        "inf": np.inf,
        "nan": np.nan,
        "newaxis": None,
        "True_": np.True_,
        "False_": np.False_,
    }
    linalg: dict[str, Any] = {
        name: Native(f"np.linalg.{name}", _array_function(name, getattr(np.linalg, name)), None, True)
        for name in LINALG
    }
    linalg["LinAlgError"] = Native("LinAlgError", np.linalg.LinAlgError, np.linalg.LinAlgError)
    names["linalg"] = Module("np.linalg", linalg)
    for name in ("errstate", "printoptions"):  # which change no result
        names[name] = Native(f"np.{name}", lambda **_: _manager(evaluator, lambda: None, lambda *_: False))
    names["random"] = Module(
        "np.random",
        {
            "default_rng": Native("np.random.default_rng", _seeded("default_rng", np.random.default_rng)),
            "RandomState": Native("np.random.RandomState", _seeded("RandomState", np.random.RandomState)),
            "Generator": Native("np.random.Generator", _no_call, np.random.Generator),
        },
    )
    return names


def _vectorized(function: Any = None, otypes: Any = None, **options: Any) -> Native:
    if function is None:
        return Native("np.vectorize", lambda each: _vectorized(each, otypes, **options))
    kinds = [host_type(each) for each in otypes] if isinstance(otypes, (list, tuple)) else otypes
    return Native("np.vectorize", np.vectorize(function, otypes=kinds, **options))


def _product(function: Callable[..., Any], left: Any, right: Any) -> Any:
    return left @ right if type(left) is Residual or type(right) is Residual else function(left, right)


def _items_of_arrays(arrays: Any) -> Iterator[Any]:
    """Iterate over the items of an array, or over those of several at the same places."""
    if isinstance(arrays, np.ndarray):
        return iter(arrays.flat)
    return zip(*(each.flat for each in np.broadcast_arrays(*arrays)))


class _Grid:
    """Object of numpy that makes an array of its indices, such as ``np.mgrid``."""

    def __init__(self, maker: Any) -> None:
        self._maker = maker

    def __getitem__(self, index: Any) -> Any:
        size = 1
        for each in index if isinstance(index, tuple) else (index,):
            if isinstance(each, slice):
                step = abs(each.step or 1)
                steps = step.real if isinstance(each.step, complex) else ((each.stop or 0) - (each.start or 0)) / step
                size *= max(int(abs(steps)), 1)
        if size > MAX_ITEMS:
            raise UnsupportedPython(f"this array has more than {MAX_ITEMS:,} items")
        return self._maker[index]


def _seeded(name: str, make: Callable[[Any], Any]) -> Callable[..., Any]:
    def create_generator(seed: Any = None) -> Any:
        if seed is None:
            raise UnsupportedPython(f"`{name}()` without a seed gives other numbers in every run", f"write `{name}(0)`")
        return make(seed)

    return create_generator


def _longest_text(value: Any) -> int:
    if isinstance(value, str):
        return len(value)
    return max(map(_longest_text, value), default=0) if isinstance(value, (list, tuple)) else 0


def _array_function(name: str, function: Callable[..., Any]) -> Callable[..., Any]:
    def call(*arguments: Any, **named: Any) -> Any:
        if name in CREATORS or name in PRODUCTS:
            check_size(name, arguments, named)
        if name in ("array", "asarray", "full") and any(_longest_text(each) > 1_000 for each in arguments):
            raise UnsupportedPython("arrays of long texts are not supported")
        for key in ("dtype", "otypes"):
            if key in named:
                kind = named[key]
                named[key] = [host_type(each) for each in kind] if isinstance(kind, list) else host_type(kind)
        given = arguments[0] if arguments else None
        if name in ("array", "asarray") and isinstance(given, Residual) and given.kind in ("array", "pose"):
            return given  # which is one, and never changes
        return function(*(host_type(each) for each in arguments), **named)

    return call


# Classes that are written in Python: the mixin methods of `collections.abc`, and what builds on them.


MIXINS = (
    "Collection", "Container", "Iterable", "Iterator", "Mapping", "MutableMapping", "MutableSequence", "Sequence",
    "Sized", "UserDict", "UserList",
)  # fmt: skip
_MIXINS = """
class Iterator(Iterable):
    def __iter__(self):
        return self
class Sequence(Collection):
    def __iter__(self):
        index = 0
        while index < len(self):
            yield self[index]
            index += 1
    def __contains__(self, value):
        return any(value is each or value == each for each in self.__iter__())
    def __reversed__(self):
        return iter([self[i] for i in reversed(range(len(self)))])
    def index(self, value):
        for i in range(len(self)):
            if self[i] == value:
                return i
        raise ValueError
    def count(self, value):
        return sum(1 for each in self if each == value)
class MutableSequence(Sequence):
    def append(self, value):
        self.insert(len(self), value)
    def extend(self, values):
        for each in list(values):
            self.append(each)
    def pop(self, index=-1):
        value = self[index]
        del self[index]
        return value
    def remove(self, value):
        del self[self.index(value)]
    def clear(self):
        while len(self):
            self.pop()
    def reverse(self):
        n = len(self)
        for i in range(n // 2):
            self[i], self[n - i - 1] = self[n - i - 1], self[i]
    def __iadd__(self, values):
        self.extend(values)
        return self
class Mapping(Collection):
    def get(self, key, default=None):
        try:
            return self[key]
        except KeyError:
            return default
    def __contains__(self, key):
        try:
            self[key]
        except KeyError:
            return False
        return True
    def keys(self):
        return dict.fromkeys(self).keys()
    def values(self):
        return {key: self[key] for key in self}.values()
    def items(self):
        return {key: self[key] for key in self}.items()
    def __eq__(self, other):
        return dict(self.items()) == dict(other.items())
class MutableMapping(Mapping):
    def pop(self, key, *default):
        try:
            value = self[key]
        except KeyError:
            if default:
                return default[0]
            raise
        del self[key]
        return value
    def popitem(self):
        for key in self:
            return key, self.pop(key)
        raise KeyError
    def clear(self):
        for key in list(self):
            del self[key]
    def setdefault(self, key, default=None):
        if key not in self:
            self[key] = default
        return self[key]
    def update(self, other=(), **named):
        for key, value in (other.items() if hasattr(other, "items") else other):
            self[key] = value
        for key, value in named.items():
            self[key] = value
class UserDict(MutableMapping):
    def __init__(self, data=None, **named):
        self.data = {}
        self.update(data or {}, **named)
    def __len__(self):
        return len(self.data)
    def __getitem__(self, key):
        if key in self.data:
            return self.data[key]
        if hasattr(self, "__missing__"):
            return self.__missing__(key)
        raise KeyError(key)
    def __setitem__(self, key, value):
        self.data[key] = value
    def __delitem__(self, key):
        del self.data[key]
    def __iter__(self):
        return iter(self.data)
    def __contains__(self, key):
        return key in self.data
class UserList(MutableSequence):
    def __init__(self, data=None):
        self.data = list(data or [])
    def __len__(self):
        return len(self.data)
    def __getitem__(self, index):
        return self.data[index]
    def __setitem__(self, index, value):
        self.data[index] = value
    def __delitem__(self, index):
        del self.data[index]
    def insert(self, index, value):
        self.data.insert(index, value)
"""


def _rotations(evaluator: PythonEvaluator) -> dict[str, Any]:
    """Return the names of scipy's module of rotations, which is evaluated as a program is."""
    names = {name: evaluator.modules[name] for name in ("math", "np")}
    frame = Frame({**names, "dataclass": evaluator.modules["dataclasses"].names["dataclass"]}, None)
    frame.names["unsupported"] = Native("unsupported", _unsupported)
    tree = ast.parse(ROTATION + STACKS)
    for node in ast.walk(tree):
        if hasattr(node, "lineno"):
            node.lineno = 0
    for _ in evaluator.execute(tree.body, frame):
        pass
    classes = {name: frame.names[name] for name in ("Rotation", "Slerp")}
    for cls in (*classes.values(), frame.names["RotationStack"]):
        cls.options["is_partial"] = True
    return classes


def _unsupported(message: str) -> None:
    raise UnsupportedPython(message)


def _mixin(evaluator: PythonEvaluator, name: str) -> Any:
    """Return a class of ``collections.abc`` with its methods, Python's own if it has none, None for another name."""
    if name not in MIXINS:
        return None
    if name not in evaluator.mixins:
        frame = Frame(dict(evaluator.modules["typing"].names), None)
        for statement in ast.parse(_MIXINS).body:
            if isinstance(statement, ast.ClassDef):
                cls = PythonClass(statement.name, {}, (), evaluator)
                base = getattr(collections.abc, statement.name, None)
                parents = [evaluator.eval(each, frame) for each in statement.bases]
                bases = [each for each in parents if type(each) is PythonClass] + ([base] if base is not None else [])
                body = Frame(cls.names, frame, is_class=True)
                for _ in evaluator.execute(statement.body, body):
                    pass
                cls.bases = tuple(bases) or (object,)
                cls.order = linearized(cls)
                frame.names[statement.name] = evaluator.mixins[statement.name] = cls
    return evaluator.mixins.get(name, getattr(collections.abc, name, object))
