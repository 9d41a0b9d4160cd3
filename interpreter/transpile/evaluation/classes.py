"""Classes of the program: definition, instances, attributes; dataclasses, enumerations, named tuples."""

from __future__ import annotations

import ast
import math
from collections import Counter, OrderedDict, defaultdict, deque
from collections.abc import Callable, Iterable
from functools import partial
from itertools import chain
from random import Random
from typing import Any

import numpy as np

from scenelang.interpreter.transpile.evaluation import (
    MAX_ITEMS,
    METHODS,
    UNSAFE,
    UnsupportedPython,
    enlarged,
    instead_of,
    outer_product,
)
from scenelang.interpreter.transpile.evaluation.objects import (
    MISSING,
    BoundMethod,
    ClassMethod,
    DataField,
    Evaluating,
    Frame,
    HostObject,
    IntMember,
    Module,
    NamedTuple,
    Native,
    Property,
    PythonClass,
    PythonFunction,
    PythonGenerator,
    PythonObject,
    StaticMethod,
    Super,
    TextMember,
    ValueObject,
    int_member,
    linearized,
    type_name,
    value_type,
)
from scenelang.interpreter.transpile.evaluation.residue import (
    Residual,
    attribute_of_residual,
    formatted,
    is_kind_of,
    is_shape,
    undecided,
)
from scenelang.interpreter.transpile.evaluation.scientific import library_attribute, library_class

# --- definition ----------------------------------------------------------------------------------------------------

ENUMERATIONS = ("Enum", "IntEnum", "StrEnum", "Flag", "IntFlag")
_MARKERS = (*ENUMERATIONS, "NamedTuple", "Protocol", "ABC", "Generic", "TypedDict")


def define(evaluator: Evaluating, node: ast.ClassDef, frame: Frame) -> PythonClass:
    """Evaluate a class definition."""
    bases: list[Any] = []
    markers: set[str] = set()
    for each in node.bases:
        value = evaluator.eval(each, frame)
        name = value.path.rpartition(".")[2] if type(value) is Native else ""
        if name in _MARKERS:
            markers.add(name)
        elif type(value) is PythonClass:
            bases.append(value)
        elif (mixin := evaluator.mixin(name)) is not None:
            bases.append(mixin)
        elif type(value) is Native and isinstance(value.type, type):
            bases.append(value.type)
        else:
            raise UnsupportedPython("this base class is not supported")
    _check_bases(bases, markers)
    for keyword in node.keywords:
        if keyword.arg == "metaclass" and ast.unparse(keyword.value).rpartition(".")[2] not in ("ABCMeta", "EnumMeta"):
            raise UnsupportedPython("metaclasses are not supported", "use a function that makes the class")
    parent = next((base for base in bases if type(base) is PythonClass and base.members is not None), None)
    kinds = (
        markers | {b.__name__ for b in bases if isinstance(b, type)} | (parent.options["kinds"] if parent else set())
    )
    is_enumeration = bool(markers & set(ENUMERATIONS)) or parent is not None
    body = Frame(_EnumerationNames(kinds) if is_enumeration else {}, frame, is_class=True)
    for _ in evaluator.execute(node.body, body):
        raise UnsupportedPython("a class body cannot yield")
    names = {private_name(node.name, name): value for name, value in body.names.items()}
    cls = PythonClass(node.name, body.names if is_enumeration else names, tuple(bases) or (object,), evaluator)
    cls.order = linearized(cls)
    _inherit_data(cls)
    cls.names.setdefault("__doc__", ast.get_docstring(node))
    for name, value in list(cls.names.items()):
        _own(value, cls)
        if type(value) is PythonObject and value.cls.find("__set_name__") is not MISSING:
            evaluator.call(value.cls.find("__set_name__"), (value, cls, name), {})
    if is_enumeration:
        _make_members(evaluator, cls, kinds)
    elif "NamedTuple" in markers:
        _make_named_tuple(cls, node)
    elif "Protocol" in markers:
        cls.options["protocol"] = [name for name in cls.names if not name.startswith("_")] + [
            name for name, _ in _annotations(node)
        ]
    elif "TypedDict" in markers:
        cls.options["is_dict"] = True
    cls.options["annotations"] = _annotations(node)
    hooks = (base.names.get("__init_subclass__", MISSING) for base in cls.order[1:] if type(base) is PythonClass)
    hook = next((each for each in hooks if each is not MISSING), MISSING)
    if hook is not MISSING:
        named = {k.arg: evaluator.eval(k.value, frame) for k in node.keywords if k.arg and k.arg != "metaclass"}
        evaluator.call(hook.function if isinstance(hook, ClassMethod) else hook, (cls,), named)
    return cls


def _inherit_data(cls: PythonClass) -> None:
    """Give a subclass of a dataclass that is none itself the fields that its inherited ``__init__`` takes."""
    makers = (b for b in cls.order if type(b) is PythonClass and (b.data is not None or "__init__" in b.names))
    maker = next(makers, None)
    if maker is not None and "__init__" not in maker.names:
        cls.data = maker.data
        cls.options |= {name: maker.options[name] for name in ("frozen", "order", "eq") if name in maker.options}


def private_name(cls: str, name: str) -> str:
    """Return a name as a class mangles it."""
    is_private = name.startswith("__") and not name.endswith("__")
    return f"_{cls.lstrip('_')}{name}" if is_private else name


_ABSTRACT = "collections.abc"
_VALUES = (bytes, complex, deque, dict, float, frozenset, int, list, set, str, tuple, Counter, OrderedDict, defaultdict)


def _check_bases(bases: list[Any], markers: set[str]) -> None:
    for base in bases:
        if isinstance(base, type) and not (
            base is object or issubclass(base, Exception) or base.__module__ == _ABSTRACT
        ):
            if not (markers & {"Enum", "Flag"} and base in (int, str, float, tuple)) and base not in _VALUES:
                hint = f"keep a {base.__name__} in a field of the class"
                raise UnsupportedPython(f"a class derived from `{base.__name__}` is not supported", hint)


def _own(value: Any, cls: PythonClass) -> None:
    """Note the class of a function, for ``super()``."""
    if type(value) is PythonFunction:
        value.owner = value.owner or cls
    elif type(value) in (StaticMethod, ClassMethod):
        _own(value.function, cls)
    elif type(value) is Property:
        _own(value.get, cls)
        _own(value.set, cls)


def _annotations(node: ast.ClassDef) -> list[tuple[str, str]]:
    return [
        (statement.target.id, ast.unparse(statement.annotation))
        for statement in node.body
        if isinstance(statement, ast.AnnAssign) and isinstance(statement.target, ast.Name)
    ]


class _EnumerationNames(dict[str, Any]):
    """Names of the body of an enumeration, in which ``auto()`` becomes a value at once."""

    def __init__(self, kinds: set[str]) -> None:
        super().__init__()
        self._kinds = kinds
        self._values: list[Any] = []

    def __setitem__(self, name: str, value: Any) -> None:
        if type(value) is PythonObject and value.cls is AUTO:
            value = self._next(name)
        if type(value) is tuple and any(type(each) is PythonObject and each.cls is AUTO for each in value):
            value = tuple(self._next(name) if type(e) is PythonObject and e.cls is AUTO else e for e in value)
        if not name.startswith("_") and not isinstance(value, (PythonFunction, Property, StaticMethod, ClassMethod)):
            self._values.append(value)
        super().__setitem__(name, value)

    def _next(self, name: str) -> Any:
        if "StrEnum" in self._kinds:
            return name.lower()
        numbers = [each for each in self._values if isinstance(each, int)]
        if self._kinds & {"Flag", "IntFlag"}:
            return 1 << max((each.bit_length() for each in numbers), default=0)
        return max(numbers, default=0) + 1


def _make_members(evaluator: Evaluating, cls: PythonClass, kinds: set[str]) -> None:
    cls.options["kinds"] = kinds
    cls.members = {}
    for name in list(cls.names):
        value = cls.names[name]
        is_function = isinstance(value, (PythonFunction, Property, StaticMethod, ClassMethod, PythonClass))
        if not name.startswith("_") and not is_function:
            cls.members[name] = _member(evaluator, cls, name, value, kinds)
            dict.__setitem__(cls.names, name, cls.members[name])


def _member(evaluator: Evaluating, cls: PythonClass, name: str, value: Any, kinds: set[str]) -> Any:
    if "str" in kinds:
        value = str(value)
    for other in (cls.members or {}).values():
        if value_of_member(other) == value and type(value_of_member(other)) is type(value):
            return other
    if kinds & {"IntEnum", "IntFlag", "Flag", "int"}:
        return int_member(cls, name, int(value), bool(kinds & {"Flag", "IntFlag"}))
    if kinds & {"StrEnum", "str"}:
        member = TextMember(value)
        member.cls, member.name, member.is_plain = cls, name, "StrEnum" in kinds
        return member
    instance = PythonObject(cls, {"name": name, "value": value})
    initialize = cls.find("__init__")
    if initialize is not MISSING:
        evaluator.call(initialize, (instance, *(value if isinstance(value, tuple) else (value,))), {})
    return instance


def value_of_member(member: Any) -> Any:
    """Return the value of a member of an enumeration."""
    if type(member) is PythonObject:
        return member.fields["value"]
    return int(member) if isinstance(member, IntMember) else str.__str__(member)


AUTO = PythonClass("auto", {}, (object,), None)  # type: ignore[arg-type]


def _make_named_tuple(cls: PythonClass, node: ast.ClassDef) -> None:
    cls.tuple_fields = {name: cls.names.pop(name, MISSING) for name, _ in _annotations(node)}


# --- instances -----------------------------------------------------------------------------------------------------


def create(evaluator: Evaluating, cls: PythonClass, arguments: tuple[Any, ...], named: dict[str, Any]) -> Any:
    """Create an instance of a class."""
    if cls.members is not None:
        return _member_of_value(cls, *arguments, **named)
    if cls.options.get("is_dict"):
        return dict(*arguments, **named)
    if cls.tuple_fields is None:
        inherited = next((b.tuple_fields for b in cls.order if type(b) is PythonClass and b.tuple_fields), None)
        cls.tuple_fields = inherited
    if cls.tuple_fields is not None:
        return _create_tuple(cls, arguments, named)
    _check_abstract(cls)
    maker = cls.find("__new__")
    if maker is not MISSING:
        made = evaluator.call(maker.function if isinstance(maker, StaticMethod) else maker, (cls, *arguments), named)
        if getattr(made, "cls", None) is not cls:
            return made
    else:
        made = _made(cls, *arguments, **named)
    if isinstance(made, ValueObject):
        return _initialize_value(evaluator, made, arguments, named)
    if cls.is_subclass(BaseException):
        made.fields["args"] = arguments
    initialize = cls.find("__init__")
    if initialize is not MISSING:
        evaluator.call(initialize, (made, *arguments), named)
    elif cls.data is not None:
        _initialize(evaluator, made, arguments, named)
    elif (arguments or named) and maker is MISSING and not cls.is_subclass(BaseException):
        raise TypeError(f"{cls.name}() takes no arguments")
    return made


def _made(cls: PythonClass, *arguments: Any, **named: Any) -> Any:
    """Create an instance that is not initialized."""
    host = next((each for each in cls.order if each in _VALUES), None)
    if host is None:
        return PythonObject(cls)
    kind = value_type(host)
    made = kind() if issubclass(host, (dict, list, set, deque)) else kind.__new__(kind, *arguments, **named)
    made.cls, made.fields = cls, {}
    return made


def _initialize_value(evaluator: Evaluating, made: Any, arguments: tuple[Any, ...], named: dict[str, Any]) -> Any:
    initialize = made.cls.find("__init__")
    if initialize is not MISSING:
        evaluator.call(initialize, (made, *arguments), named)
    elif issubclass(made.host, (dict, list, set, deque)):
        made.host.__init__(made, *arguments, **named)
    return made


def _check_abstract(cls: PythonClass) -> None:
    missing: list[str] = []
    for base in reversed(cls.order):
        for name, value in base.names.items() if type(base) is PythonClass else ():
            function = value.get if type(value) is Property else getattr(value, "function", value)
            is_abstract = type(function) is PythonFunction and function.attributes.get("is_abstract")
            if name in missing and not is_abstract:
                missing.remove(name)
            elif is_abstract and name not in missing:
                missing.append(name)
    if missing:
        plural = "s" if len(missing) > 1 else ""
        listed = ", ".join(sorted(f"'{name}'" for name in missing))
        reason = f"without an implementation for abstract method{plural} {listed}"
        raise TypeError(f"Can't instantiate abstract class {cls.name} {reason}")


def _member_of_value(cls: PythonClass, value: Any) -> Any:
    for member in cls:
        if member is value or value_of_member(member) == value:
            return member
    if cls.options["kinds"] & {"Flag", "IntFlag"} and isinstance(value, int):
        return int_member(cls, None, 0, True)._combined(int(value))
    raise ValueError(f"{value!r} is not a valid {cls.name}")


def _create_tuple(cls: PythonClass, arguments: tuple[Any, ...], named: dict[str, Any]) -> NamedTuple:
    fields = cls.tuple_fields or {}
    values = {**{k: v for k, v in fields.items() if v is not MISSING}, **dict(zip(fields, arguments)), **named}
    if len(arguments) > len(fields) or set(values) != set(fields):
        wrong = sorted(set(values) ^ set(fields))
        raise TypeError(f"{cls.name}.__new__() has wrong arguments: {', '.join(wrong)}")
    made = NamedTuple(tuple(values[name] for name in fields))
    made.cls, made.fields = cls, {}
    return made


def _initialize(evaluator: Evaluating, made: PythonObject, arguments: tuple[Any, ...], named: dict[str, Any]) -> None:
    """Initialize an instance of a dataclass."""
    fields = [each for each in made.cls.data or () if each.in_init]
    positional = [each.name for each in fields if not each.is_keyword]
    if len(arguments) > len(positional):
        count = len(positional) + 1
        raise TypeError(
            f"{made.cls.name}.__init__() takes {count} positional arguments but {len(arguments) + 1} were given"
        )
    given = {**dict(zip(positional, arguments)), **named}
    unknown = sorted(set(given) - {each.name for each in fields})
    if unknown:
        raise TypeError(f"{made.cls.name}.__init__() got an unexpected keyword argument '{unknown[0]}'")
    passed: list[Any] = []
    for each in made.cls.data or ():
        if each.in_init and each.name in given:
            value = given[each.name]
        elif each.factory is not MISSING:
            value = evaluator.call(each.factory, (), {})
        elif each.default is not MISSING:
            value = each.default
        elif each.in_init:
            raise TypeError(f"{made.cls.name}.__init__() missing 1 required positional argument: '{each.name}'")
        else:
            continue
        if each.is_init_only:
            passed.append(value)
        else:
            made.fields[each.name] = value
    finish = made.cls.find("__post_init__")
    if finish is not MISSING:
        evaluator.call(finish, (made, *passed), {})


# --- attributes ----------------------------------------------------------------------------------------------------

_VIEWS: tuple[type, ...] = (type({}.keys()), type({}.items()), type({}.values()))
_UNSAFE = "interpreter internals are not available"


def attribute_of(evaluator: Evaluating, value: Any, name: str, default: Any) -> Any:
    """Return an attribute of a value, or the default if it is missing; without a default, raises AttributeError."""
    attribute = _attribute_or_missing(evaluator, value, name)
    if attribute is not MISSING:
        return attribute
    if default is not UnsupportedPython:
        return default
    if type(value) is Residual:
        raise UnsupportedPython(f"`{name}` of a value of the finished scene is not supported")
    if isinstance(value, Module):
        path = f"{value.path}.{name}"
        kind_of_error = "python-forbidden" if value.path in UNSAFE else "python-unsupported"
        raise UnsupportedPython(f"`{path}` is not supported", instead_of(path), kind_of_error)
    cls = value if type(value) is PythonClass else getattr(value, "cls", None)
    if type(cls) is PythonClass and cls.options.get("is_partial"):
        raise UnsupportedPython(f"`{name}` of a {cls.name} is not supported")
    kind = type(value) if not isinstance(value, (Native, PythonClass)) else None
    if kind is not None and not isinstance(value, ValueObject) and hasattr(kind, name) and not name.startswith("_"):
        raise UnsupportedPython(f"`{name}` of a {type_name(value)} is not supported")
    what = f"type object '{value.name}'" if type(value) is PythonClass else f"'{type_name(value)}' object"
    raise AttributeError(f"{what} has no attribute '{name}'")


def _attribute_or_missing(evaluator: Evaluating, value: Any, name: str) -> Any:
    """Return an attribute of a value of any type, MISSING if it has none."""
    kind = type(value)
    if kind is PythonObject:
        return _of_object(evaluator, value, name)
    if kind is PythonClass:
        return _of_class(evaluator, value, name)
    if kind is Super:
        return _of_super(evaluator, value, name)
    if kind is Module:
        return value.names.get(name, MISSING)
    if kind in (IntMember, TextMember) or isinstance(value, ValueObject):
        own = _of_member(evaluator, value, name)
        if own is not MISSING:
            return own
    if kind in (PythonFunction, Native, BoundMethod):
        return _of_function(evaluator, value, name)
    if kind is Residual:
        return attribute_of_residual(evaluator, value, name)
    if kind is Property:
        return _of_property(value, name)
    if isinstance(value, HostObject):
        return value.read(name)
    if kind is PythonGenerator:
        known = {"send": "send", "close": "close", "__next__": "__next__"}
        return Native(name, getattr(value.steps, known[name])) if name in known else MISSING
    if name.startswith("_"):
        return _special(evaluator, value, name)
    # host values have only the listed attributes: others could lead to the interpreter's internals
    for each, names in METHODS.items():
        if isinstance(value, each) and name in names:
            return _own_attribute(evaluator, value, name)
    if isinstance(value, _VIEWS) and name in ("isdisjoint",):
        return Native(name, getattr(value, name))
    row = library_class(value)
    return MISSING if row is None else library_attribute(value, row, name, MISSING)


def _own_attribute(evaluator: Evaluating, value: Any, name: str) -> Any:
    """Return an attribute of one of Python's own values; a method becomes a function of the evaluator."""
    if name == "format":
        return Native(name, lambda *rest, **named: format_text(evaluator, value, rest, named))
    attribute = getattr(value, name)
    if not callable(attribute) or isinstance(attribute, (np.ndarray, np.dtype)):
        return attribute if not isinstance(attribute, (type, np.dtype)) else _dtype(attribute)
    if name == "extend" and isinstance(value, list):
        return Native("extend", lambda items: value.extend(evaluator.spread(items) if is_shape(items) else items))
    if name == "join":
        return Native("join", partial(_joined, value))
    if name in ("repeat", "substitute", "safe_substitute", "translate"):
        return Native(name, partial(enlarged, value, attribute))
    if name in ("center", "expandtabs", "ljust", "replace", "rjust", "zfill") and isinstance(value, (str, bytes)):
        return Native(name, partial(_padded, value, name))
    if isinstance(value, (Random, np.random.Generator, np.random.RandomState)):
        return Native(name, limited_draw(name, attribute))
    if name == "astype":
        return Native(name, lambda kind: attribute(host_type(kind)))
    return Native(name, attribute)


def _dtype(dtype: Any) -> Native:
    parts = {name: getattr(dtype, name) for name in ("name", "kind", "itemsize") if hasattr(dtype, name)}
    return Native(str(dtype), lambda: dtype, dtype, attributes=parts)


def limited_draw(name: str, draw: Callable[..., Any]) -> Callable[..., Any]:
    """Return a method of a stream of random numbers that refuses to draw very many."""

    def limited(*arguments: Any, **named: Any) -> Any:
        if name == "seed":
            return draw(*([each for each in arguments if each is not None] or [0]), **named)
        is_range = name in ("integers", "randint", "randrange", "random_integers", "seed")  # whose ends are no sizes
        sizes = [*(arguments[2:] if is_range else arguments), *(named[key] for key in ("size", "k") if key in named)]
        for size in sizes:
            numbers = size if isinstance(size, tuple) else (size,)
            if all(isinstance(each, int) for each in numbers) and math.prod(map(abs, numbers)) > MAX_ITEMS:
                raise UnsupportedPython("this draw has too many numbers")
        return draw(*(host_type(each) for each in arguments), **{key: host_type(v) for key, v in named.items()})

    return limited


def _padded(text: str | bytes, name: str, *arguments: Any, **named: Any) -> Any:
    """Call a method whose result may be much longer than the text."""
    size = len(text) + sum(each for each in arguments if isinstance(each, int))
    if name == "replace":
        size = len(text) + (len(text) + 1) * len(arguments[1])
    elif name == "expandtabs":
        size = len(text) * max(1, *(each for each in arguments if isinstance(each, int)))
    if size > MAX_ITEMS:
        raise UnsupportedPython(f"this text has more than {MAX_ITEMS:,} characters")
    return getattr(text, name)(*arguments, **named)


def _joined(separator: Any, items: Iterable[Any]) -> Any:
    parts = list(items)
    if len(separator) * len(parts) + sum(len(each) for each in parts if isinstance(each, (str, bytes))) > MAX_ITEMS:
        raise UnsupportedPython(f"this text has more than {MAX_ITEMS:,} characters")
    return separator.join(parts)


def host_type(kind: Any) -> Any:
    """Return Python's or numpy's type for a type of the evaluator."""
    return kind.type if type(kind) is Native and kind.type is not None else kind


def _of_object(evaluator: Evaluating, value: PythonObject, name: str) -> Any:
    """Return an attribute of an instance, MISSING if it has none; the order of lookup is CPython's."""
    attribute = value.cls.find(name)
    # data descriptors precede fields, other descriptors follow them
    if type(attribute) is PythonObject and (name not in value.fields or attribute.cls.find("__set__") is not MISSING):
        get = attribute.cls.find("__get__")
        if get is not MISSING:
            return evaluator.call(get, (attribute, value, value.cls), {})
    if type(attribute) is Property and not (attribute.is_cached and name in value.fields):
        result = evaluator.call(attribute.get, (value,), {})
        if attribute.is_cached:
            value.fields[name] = result
        return result
    if name in value.fields:
        return value.fields[name]
    if attribute is not MISSING:
        return _bound(evaluator, attribute, value, value.cls)
    if name == "__class__":
        return value.cls
    if name in ("__cause__", "__context__"):
        return None
    if name == "__dict__":
        return value.fields
    if name == "_value_" and value.cls.members is not None:
        return value.fields["value"]
    fallback = value.cls.find("__getattr__") if not name.startswith("__") else MISSING
    if fallback is not MISSING:
        return evaluator.call(fallback, (value, name), {})
    return _protocol(value, name)


_PROTOCOL = {"__str__": str, "__repr__": repr, "__eq__": lambda a, b: a == b, "__hash__": hash}


def _protocol(value: Any, name: str) -> Any:
    function = _PROTOCOL.get(name)
    return MISSING if function is None else Native(name, lambda *rest: function(value, *rest))  # type: ignore[operator]


def _bound(evaluator: Evaluating, attribute: Any, value: Any, cls: PythonClass) -> Any:
    if type(attribute) is PythonFunction:
        return BoundMethod(attribute, value, evaluator)
    if type(attribute) is Native and attribute.attributes.get("is_method"):
        return BoundMethod(attribute, value, evaluator)
    if type(attribute) is ClassMethod:
        return BoundMethod(attribute.function, cls, evaluator)
    if type(attribute) is StaticMethod:
        return attribute.function
    return attribute


def _of_class(evaluator: Evaluating, cls: PythonClass, name: str) -> Any:
    """Return an attribute of a class, MISSING if it has none; raises UnsupportedPython for internals."""
    attribute = cls.find(name)
    if attribute is not MISSING:
        if type(attribute) is PythonObject and attribute.cls.find("__get__") is not MISSING:
            return evaluator.call(attribute.cls.find("__get__"), (attribute, None, cls), {})
        if type(attribute) is ClassMethod:
            return BoundMethod(attribute.function, cls, evaluator)
        return attribute.function if type(attribute) is StaticMethod else attribute
    if name in ("__name__", "__qualname__"):
        return cls.name
    if name == "__members__" and cls.members is not None:
        return dict(cls.members)
    # the usual start of a sandbox escape: subclasses of `object` include classes of the host
    if name == "__subclasses__":
        raise UnsupportedPython(_UNSAFE, None, "python-forbidden")
    if name in ("__mro__", "__bases__", "mro"):
        classes = cls.bases if name == "__bases__" else cls.order
        shown = tuple(type_named(evaluator, each) if isinstance(each, type) else each for each in classes)
        return shown if name != "mro" else Native("mro", lambda: list(shown))
    if name == "__annotations__":
        return dict(cls.options.get("annotations", ()))
    if name in ("__dict__", "__module__"):
        raise UnsupportedPython(_UNSAFE, None, "python-forbidden")
    if cls.tuple_fields is not None and name in ("_fields", "_make", "_field_defaults"):
        if name == "_fields":
            return tuple(cls.tuple_fields)
        return Native(name, lambda items: create(evaluator, cls, tuple(items), {}))
    if name in ("__init__", "__setattr__", "__post_init__", "__new__"):
        return _basic(evaluator, name)
    return MISSING


def _basic(evaluator: Evaluating, name: str) -> Any:
    """Return a method of ``object``."""
    if name == "__setattr__":
        return Native(name, lambda value, key, new: value.fields.__setitem__(key, new))
    if name == "__new__":
        return Native(name, _made)
    if name == "__init__":
        return Native(name, lambda value, *rest, **named: _initialize_basic(evaluator, value, rest, named))
    if name in ("__post_init__", "__init_subclass__", "__enter__"):
        return Native(name, lambda *rest, **named: None)
    return MISSING


def _initialize_basic(evaluator: Evaluating, value: Any, rest: tuple[Any, ...], named: dict[str, Any]) -> None:
    if type(value) is PythonObject and value.cls.is_subclass(BaseException):
        value.fields["args"] = rest
    elif type(value) is PythonObject and value.cls.data is not None and (rest or named):
        _initialize(evaluator, value, rest, named)


def _of_super(evaluator: Evaluating, value: Super, name: str) -> Any:
    """Return an attribute of ``super()``: the next definition in the method resolution order."""
    cls = value.value if type(value.value) is PythonClass else value.value.cls
    order = cls.order
    start = next((i for i, each in enumerate(order) if each is value.cls), -1)
    for each in order[start + 1 :]:
        if type(each) is PythonClass and name in each.names:
            attribute = each.names[name]
            if type(attribute) is Property:
                return evaluator.call(attribute.get, (value.value,), {})
            return _bound(evaluator, attribute, value.value, cls)
        # the generated `__init__` of a data class is not among its names
        if type(each) is PythonClass and name == "__init__" and each.data is not None:
            return Native(name, partial(_initialize_as, evaluator, value.value, each))
    if isinstance(value.value, ValueObject):
        host = value.value.host
        if (name in METHODS.get(host, ()) or name in _OPERATIONS) and hasattr(host, name):
            return Native(name, lambda *rest, **named: getattr(host, name)(value.value, *rest, **named))
    basic = _basic(evaluator, name)
    if basic is not MISSING:
        return basic if name == "__new__" else BoundMethod(basic, value.value, evaluator)
    shown = {"__str__": str, "__repr__": repr}.get(name)
    if shown is not None and cls.is_subclass(BaseException):
        args = value.value.fields.get("args", ())
        return Native(name, lambda: str(args[0]) if len(args) == 1 else str(args))
    return _protocol(value.value, name) if name in ("__eq__", "__hash__") else MISSING


_OPERATIONS = frozenset(
    [
        "__init__",
        "__getitem__",
        "__setitem__",
        "__delitem__",
        "__contains__",
        "__len__",
        "__iter__",
        "__repr__",
        "__str__",
        "__add__",
        "__radd__",
        "__sub__",
        "__mul__",
        "__rmul__",
        "__truediv__",
        "__floordiv__",
        "__mod__",
        "__neg__",
        "__abs__",
        "__eq__",
        "__lt__",
        "__hash__",
    ]
)


def _initialize_as(evaluator: Evaluating, value: PythonObject, cls: PythonClass, *rest: Any, **named: Any) -> None:
    """Initialize the fields that a base class declares."""
    part = PythonObject(cls, value.fields)
    _initialize(evaluator, part, rest, named)


def _of_member(evaluator: Evaluating, value: Any, name: str) -> Any:
    """Return an attribute of a named tuple, an enumeration member or an instance of a subclass of a built-in class."""
    if type(value) is NamedTuple:
        fields = list(value.cls.tuple_fields or ())
        if name in fields:
            return value[fields.index(name)]
        if name == "_replace":
            return Native(name, lambda **new: create(evaluator, value.cls, (), {**dict(zip(fields, value)), **new}))
        if name == "_asdict":
            return Native(name, lambda: dict(zip(fields, value)))
        if name == "_fields":
            return tuple(fields)
    elif isinstance(value, ValueObject):
        if name in value.fields:
            return value.fields[name]
    elif name in ("name", "value", "_name_", "_value_"):
        return value.name if "name" in name else value_of_member(value)
    attribute = value.cls.find(name)
    if type(attribute) is Property:
        return evaluator.call(attribute.get, (value,), {})
    if name == "__class__":
        return value.cls
    return MISSING if attribute is MISSING else _bound(evaluator, attribute, value, value.cls)


def _of_function(evaluator: Evaluating, value: Any, name: str) -> Any:
    """Return an attribute of a function, method or built-in type, MISSING if it has none."""
    if type(value) is Native and "__refused__" in value.attributes:
        # raises the error of the unsupported import
        value()
    if type(value) is BoundMethod:
        return value.value if name == "__self__" else _of_function(evaluator, value.function, name)
    if type(value) is PythonFunction and name in ("__qualname__", "__defaults__", "__kwdefaults__"):
        known = {"__qualname__": value.qualified, "__kwdefaults__": value.keyword_defaults or None}
        return known.get(name, value.defaults or None)
    if name in ("__name__", "__qualname__"):
        return value.name if type(value) is PythonFunction else value.path.rpartition(".")[2]
    if name in value.attributes:
        return value.attributes[name]
    is_numeric = type(value) is Native and value.path.startswith("np.")
    host = getattr(np, value.path.removeprefix("np."), None) if is_numeric else None
    if isinstance(host, np.ufunc) and name in ("accumulate", "at", "outer", "reduce"):
        return Native(f"{value.path}.{name}", outer_product(host) if name == "outer" else getattr(host, name))
    if type(value) is Native and value.path == "object":
        return _basic(evaluator, name)
    if type(value) is Native and isinstance(value.type, type) and not name.startswith("_"):
        if value.type is str and name == "format":
            return Native(name, lambda text, *rest, **named: format_text(evaluator, text, rest, named))
        names = next((METHODS[each] for each in value.type.__mro__ if each in METHODS), frozenset[str]())
        if (value.type, name) == (chain, "from_iterable"):
            return Native(name, lambda rows: _chained(evaluator, rows))
        if name in names or (value.type, name) == (dict, "fromkeys"):
            return Native(name, getattr(value.type, name))
    if type(value) is Native and isinstance(value.type, type) and issubclass(value.type, BaseException):
        return _basic(evaluator, name)
    if name.startswith("__") and name not in ("__doc__", "__wrapped__", "__module__"):
        raise UnsupportedPython(_UNSAFE, None, "python-forbidden")
    return MISSING


def _chained(evaluator: Evaluating, rows: Any) -> Any:
    """Return the items of rows; those of shapes as a list, for which the program adds their primitives to one."""
    rows = evaluator.iterate(rows)
    first = next(rows, MISSING)
    if is_shape(first):
        items = evaluator.spread(first)
        for row in rows:
            items += evaluator.spread(row) if is_shape(row) else evaluator.iterate(row)
        return items
    return chain.from_iterable(chain([] if first is MISSING else [first], rows))


def _of_property(value: Property, name: str) -> Any:
    if name == "setter":
        return Native(name, lambda function: Property(value.get, function, value.delete))
    if name == "deleter":
        return Native(name, lambda function: Property(value.get, value.set, function))
    if name == "getter":
        return Native(name, lambda function: Property(function, value.set, value.delete))
    return MISSING


_PLAIN = frozenset(
    [
        "__abs__",
        "__add__",
        "__bool__",
        "__contains__",
        "__eq__",
        "__float__",
        "__floordiv__",
        "__ge__",
        "__getitem__",
        "__gt__",
        "__hash__",
        "__int__",
        "__iter__",
        "__le__",
        "__len__",
        "__lt__",
        "__ne__",
        "__neg__",
        "__next__",
        "__radd__",
        "__round__",
        "__rsub__",
        "__sub__",
        "__truediv__",
    ]
)  # methods whose results are not much larger than their arguments


def _special(evaluator: Evaluating, value: Any, name: str) -> Any:
    if name == "__cause__" and isinstance(value, BaseException):
        return value.__cause__
    if name == "__class__":
        return type_of(evaluator, value)
    if name in ("__enter__", "__exit__") and hasattr(value, name):
        return Native(name, getattr(value, name))
    if name in _PLAIN:
        return Native(name, getattr(value, name)) if hasattr(value, name) else MISSING
    if name.startswith("__") and hasattr(type(value), name):
        raise UnsupportedPython(_UNSAFE, None, "python-forbidden")
    return MISSING


def set_attribute(evaluator: Evaluating, value: Any, name: str, new: Any) -> None:
    """Assign an attribute of a value."""
    if type(value) is PythonObject:
        attribute = value.cls.find(name)
        if type(attribute) is PythonObject and attribute.cls.find("__set__") is not MISSING:
            evaluator.call(attribute.cls.find("__set__"), (attribute, value, new), {})
            return
        if type(attribute) is Property and not attribute.is_cached:
            if attribute.set is None:
                raise AttributeError(f"property '{name}' of '{value.cls.name}' object has no setter")
            evaluator.call(attribute.set, (value, new), {})
            return
        own = value.cls.find("__setattr__")
        if own is not MISSING:
            evaluator.call(own, (value, name, new), {})
            return
        if value.cls.options.get("frozen") or (value.cls.members is not None and name in ("name", "value")):
            raise AttributeError(f"cannot assign to field '{name}'")
        value.fields[name] = new
    elif isinstance(value, ValueObject) and type(value) is not NamedTuple:
        value.fields[name] = new
    elif isinstance(value, HostObject):
        value.assign(name, new)
    elif type(value) is PythonClass and not name.startswith("__"):
        value.names[name] = new
    elif type(value) is PythonFunction:
        value.attributes[name] = new
    elif isinstance(value, np.ndarray) and name in ("shape",):
        value.shape = new
    elif isinstance(value, (NamedTuple, IntMember, TextMember)):
        raise AttributeError("can't set attribute")
    else:
        raise UnsupportedPython(f"attributes of a {type_name(value)} cannot be assigned")


# --- texts ---------------------------------------------------------------------------------------------------------


def format_text(evaluator: Evaluating, text: str, arguments: tuple[Any, ...], named: dict[str, Any]) -> str:
    """Format a text as ``str.format`` does; attributes are those of the evaluator."""
    from string import Formatter

    longest = max((len(each) for each in (*arguments, *named.values()) if type(each) is str), default=1)
    if len(text) * longest > 10**8:
        raise UnsupportedPython(f"this text has more than {MAX_ITEMS:,} characters")

    class Safe(Formatter):
        def get_field(self, field_name: str, args: Any, kwargs: Any) -> Any:
            first, rest = _split(field_name)
            value = self.get_value(first, args, kwargs)
            for is_attribute, name in rest:
                if is_attribute and name.startswith("__"):
                    raise UnsupportedPython(f"`{name}` in a text to format is not supported")
                value = evaluator.attribute(value, name) if is_attribute else value[name]
            return value, first

        def format_field(self, value: Any, format_spec: str) -> Any:
            return formatted(value, format_spec)

    return Safe().vformat(text, arguments, named)


def _split(field: str) -> tuple[int | str, list[tuple[bool, str]]]:
    from _string import formatter_field_name_split  # type: ignore[import-not-found]

    first, rest = formatter_field_name_split(field)
    return first, list(rest)


# --- types and arguments -------------------------------------------------------------------------------------------


_OWN_TYPES = (PythonFunction, BoundMethod, PythonGenerator, Module)


def _no_instance(*_: Any, **__: Any) -> Any:
    raise UnsupportedPython("this type cannot be called")


def is_instance(evaluator: Evaluating, value: Any, kind: Any) -> bool:
    """Return whether a value is an instance of a class, or of one of several."""
    if isinstance(kind, tuple):
        return any(is_instance(evaluator, value, each) for each in kind)
    cls = getattr(value, "cls", None) if not isinstance(value, (Residual, Super)) else None
    if kind is None:
        return value is None
    if isinstance(kind, PythonClass) and "protocol" in kind.options:
        return all(evaluator.attribute(value, name, MISSING) is not MISSING for name in kind.options["protocol"])
    if isinstance(kind, PythonClass):
        return cls is not None and type(cls) is PythonClass and cls.is_subclass(kind)
    if not isinstance(kind, Native) or kind.type is None:
        raise TypeError("isinstance() arg 2 must be a type, a tuple of types, or a union")
    if type(value) is Residual:
        return is_kind_of(value, kind.type)
    if type(value) is PythonObject and cls is not None:
        return bool(cls.is_subclass(kind.type))
    if kind.type is Callable:
        return callable(value)
    if isinstance(value, (PythonFunction, BoundMethod, Native, PythonClass, Module)):
        is_type = type(value) is PythonClass or (type(value) is Native and value.type is not None)
        return kind.type is object or kind.type is (type if is_type else type(value))
    return isinstance(value, kind.type)


def type_of(evaluator: Evaluating, value: Any) -> Any:
    """Return the type of a value, as ``type`` does."""
    own = getattr(value, "cls", None) if not isinstance(value, (Super, Residual)) else None
    if type(own) is PythonClass:
        return own
    if type(value) is Residual:
        hosts = {"int": int, "float": float, "bool": bool, "shape": list, "array": np.ndarray, "pose": np.ndarray}
        if value.kind not in hosts:
            raise undecided(value)
        return type_named(evaluator, hosts[value.kind])
    is_type = type(value) is PythonClass or (type(value) is Native and value.type is not None)
    return type_named(evaluator, type if is_type else type(value))


def type_named(evaluator: Evaluating, host: type) -> Any:
    """Return a type of Python as a value of the program."""
    known = evaluator.builtins.get(host.__name__)
    if type(known) is Native and known.type is host:
        return known
    name = type_name(object.__new__(host)) if host in _OWN_TYPES else host.__name__
    return evaluator.types.setdefault(host, Native(name, _no_instance, host))


def bound_arguments(function: PythonFunction, arguments: tuple[Any, ...], named: dict[str, Any]) -> dict[str, Any]:
    """Return the values of the parameters for a call, as Python binds them. Raises TypeError."""
    given, name = function.node.args, function.qualified
    positional = [each.arg for each in (*given.posonlyargs, *given.args)]
    by_name = {each.arg for each in (*given.args, *given.kwonlyargs)}
    values: dict[str, Any] = dict(zip(positional, arguments))
    rest = arguments[len(positional) :]
    if rest and given.vararg is None:
        _too_many(function, positional, len(arguments))
    extra: dict[str, Any] = {}
    wrong = [] if given.kwarg else [f"{each.arg}" for each in given.posonlyargs if each.arg in named]
    if wrong:
        reason = "got some positional-only arguments passed as keyword arguments"
        raise TypeError(f"{name}() {reason}: '{', '.join(wrong)}'")
    for key, value in named.items():
        if key in by_name:
            if key in values:
                raise TypeError(f"{name}() got multiple values for argument '{key}'")
            values[key] = value
        elif given.kwarg is not None:
            extra[key] = value
        else:
            raise TypeError(f"{name}() got an unexpected keyword argument '{key}'")
    for key, value in zip(positional[len(positional) - len(function.defaults) :], function.defaults):
        values.setdefault(key, value)
    for key, value in function.keyword_defaults.items():
        values.setdefault(key, value)
    for kind, names in (("positional", positional), ("keyword-only", [each.arg for each in given.kwonlyargs])):
        missing = [f"'{key}'" for key in names if key not in values]
        if missing:
            listed = " and ".join(missing)
            if len(missing) > 2:
                listed = f"{', '.join(missing[:-1])}, and {missing[-1]}"
            plural = "s" if len(missing) > 1 else ""
            raise TypeError(f"{name}() missing {len(missing)} required {kind} argument{plural}: {listed}")
    if given.vararg is not None:
        values[given.vararg.arg] = rest
    if given.kwarg is not None:
        values[given.kwarg.arg] = extra
    return values


def _too_many(function: PythonFunction, positional: list[str], count: int) -> None:
    least, most = len(positional) - len(function.defaults), len(positional)
    taken = f"{most}" if least == most else f"from {least} to {most}"
    plural, were = "" if taken == "1" else "s", "was" if count == 1 else "were"
    raise TypeError(f"{function.qualified}() takes {taken} positional argument{plural} but {count} {were} given")


# --- dataclasses, named tuples and copies ---------------------------------------------------------------------------


def named_tuple(evaluator: Evaluating, name: str, fields: Any, defaults: Iterable[Any] = ()) -> PythonClass:
    """Create a class of named tuples, as ``collections.namedtuple`` does."""
    names = fields.replace(",", " ").split() if isinstance(fields, str) else list(fields)
    cls = PythonClass(name, {}, (object,), evaluator)
    cls.order = linearized(cls)
    values = list(defaults)
    cls.tuple_fields = dict.fromkeys(names, MISSING) | dict(zip(names[len(names) - len(values) :], values))
    return cls


def make_dataclass(evaluator: Evaluating, cls: PythonClass, options: dict[str, Any]) -> PythonClass:
    """Make a class a dataclass."""
    fields: dict[str, DataField] = {}
    for base in reversed(cls.order[1:]):
        if type(base) is PythonClass and base.data is not None:
            fields.update({each.name: each for each in base.data})
    is_keyword = bool(options.get("kw_only"))
    for name, annotation in cls.options.get("annotations", ()):
        if annotation.startswith(("ClassVar", "typing.ClassVar")):
            continue
        if annotation in ("KW_ONLY", "dataclasses.KW_ONLY"):
            is_keyword = True
            continue
        value = cls.names.get(name, MISSING)
        data_field = value if type(value) is DataField else DataField(name, value)
        data_field.name = name
        data_field.is_keyword = data_field.is_keyword or is_keyword
        data_field.is_init_only = annotation.startswith(("InitVar", "dataclasses.InitVar"))
        if type(value) is DataField:
            cls.names.pop(name)
            if data_field.default is not MISSING:
                cls.names[name] = data_field.default
        if isinstance(data_field.default, (list, dict, set)):
            kind = type(data_field.default)
            raise ValueError(f"mutable default {kind} for field {name} is not allowed: use default_factory")
        fields[name] = data_field
    cls.data = tuple(fields.values())
    inherited = next((base.options for base in cls.order[1:] if type(base) is PythonClass and base.data), {})
    cls.options |= {key: value for key, value in inherited.items() if key in ("frozen",)} | options
    return cls


def mapping_of(evaluator: Evaluating, value: Any) -> Any:
    """Return the keys and values of a mapping that the program defines as a table; return other values unchanged."""
    keys = value.method("keys") if type(value) is PythonObject else None
    return value if keys is None else {key: value[key] for key in keys()}


def shallow_copy(value: Any) -> Any:
    """Copy a value."""
    if type(value) is PythonObject:
        method = value.method("__copy__")
        return method() if method is not None else PythonObject(value.cls, dict(value.fields))
    if isinstance(value, ValueObject):
        host: Any = value.host
        kind, plain = type(value), value.plain()
        made: Any = host.__new__(kind) if issubclass(host, (dict, list, set, deque)) else host.__new__(kind, plain)
        host.__init__(made, *([plain] if issubclass(host, (dict, list, set, deque)) else []))
        made.cls, made.fields = value.cls, dict(value.fields)
        return made
    return value.copy() if isinstance(value, (list, dict, set, deque, np.ndarray)) else value


def attribute_name(node: ast.Attribute, frame: Frame) -> str:
    """Return the name of an attribute, as the class mangles it in whose methods it stands."""
    scope: Frame | None = frame if node.attr.startswith("__") and not node.attr.endswith("__") else None
    while scope is not None:
        if scope.function is not None and scope.function.owner is not None:
            return private_name(scope.function.owner.name, node.attr)
        scope = scope.outer
    return node.attr
