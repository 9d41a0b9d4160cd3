"""Classes of the program: definition, instances, attributes; dataclasses, enumerations, named tuples."""

from __future__ import annotations

import ast
import collections.abc as abstract
from collections import ChainMap, Counter, OrderedDict, defaultdict, deque
from collections.abc import Iterable
from fractions import Fraction
from functools import partial
from itertools import chain
from random import Random
from re import Match, Pattern
from string import Template
from typing import Any

import numpy as np

from scenelang.interpreter.transpile.evaluation.objects import (
    MAX_ITEMS,
    MISSING,
    BoundMethod,
    ClassMethod,
    DataField,
    DictObject,
    Evaluating,
    Frame,
    IntMember,
    ListObject,
    Module,
    NamedTuple,
    Native,
    Property,
    PythonClass,
    PythonFunction,
    PythonGenerator,
    PythonObject,
    Residual,
    StaticMethod,
    Super,
    TextMember,
    UnsupportedPython,
    formatted,
    int_member,
    is_shape,
    linearized,
    type_name,
)

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
        elif name in MIXINS:
            bases.append(_mixin(evaluator, name))
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
    cls = PythonClass(node.name, body.names, tuple(bases) or (object,), evaluator)
    cls.order = linearized(cls)
    cls.names.setdefault("__doc__", ast.get_docstring(node))
    for value in cls.names.values():
        _own(value, cls)
    if is_enumeration:
        _make_members(evaluator, cls, node, kinds)
    elif "NamedTuple" in markers:
        _make_named_tuple(cls, node)
    elif "Protocol" in markers:
        cls.options["protocol"] = [name for name in cls.names if not name.startswith("_")] + [
            name for name, _ in _annotations(node)
        ]
    elif "TypedDict" in markers:
        cls.options["is_dict"] = True
    cls.options["annotations"] = _annotations(node)
    hook = next((base.find("__init_subclass__") for base in bases if type(base) is PythonClass), MISSING)
    if hook is not MISSING:
        named = {k.arg: evaluator.eval(k.value, frame) for k in node.keywords if k.arg and k.arg != "metaclass"}
        evaluator.call(hook.function if isinstance(hook, ClassMethod) else hook, (cls,), named)
    return cls


_ABSTRACT = "collections.abc"


def _check_bases(bases: list[Any], markers: set[str]) -> None:
    for base in bases:
        if isinstance(base, type) and not (
            base is object or issubclass(base, Exception) or base.__module__ == _ABSTRACT
        ):
            if not (markers & {"Enum", "Flag"} and base in (int, str, float, tuple)) and base not in (dict, list):
                hint = f"keep a {base.__name__} in a field of the class"
                raise UnsupportedPython(f"a class derived from `{base.__name__}` is not supported", hint)


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
        return list(self)
    def values(self):
        return [self[key] for key in self]
    def items(self):
        return [(key, self[key]) for key in self]
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
"""  # the mixin methods of `collections.abc`, and what builds on them


def _mixin(evaluator: Evaluating, name: str) -> Any:
    """Return a class of ``collections.abc`` with its methods; those without are Python's own."""
    if name not in evaluator.mixins:
        frame = Frame(dict(evaluator.modules["typing"].names), None)
        for statement in ast.parse(_MIXINS).body:
            if isinstance(statement, ast.ClassDef):
                cls = PythonClass(statement.name, {}, (), evaluator)
                base = getattr(abstract, statement.name, None)
                parents = [evaluator.eval(each, frame) for each in statement.bases]
                bases = [each for each in parents if type(each) is PythonClass] + ([base] if base is not None else [])
                body = Frame(cls.names, frame, is_class=True)
                for _ in evaluator.execute(statement.body, body):
                    pass
                cls.bases = tuple(bases) or (object,)
                cls.order = linearized(cls)
                frame.names[statement.name] = evaluator.mixins[statement.name] = cls
    return evaluator.mixins.get(name, getattr(abstract, name, object))


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
        if self._kinds & {"StrEnum", "str"}:
            return name.lower()
        numbers = [each for each in self._values if isinstance(each, int)]
        if self._kinds & {"Flag", "IntFlag"}:
            return 1 << max((each.bit_length() for each in numbers), default=0)
        return max(numbers, default=0) + 1


def _make_members(evaluator: Evaluating, cls: PythonClass, node: ast.ClassDef, kinds: set[str]) -> None:
    cls.options["kinds"] = kinds
    cls.members = {}
    assigned = {
        target.id
        for statement in node.body
        if isinstance(statement, ast.Assign)
        for target in statement.targets
        if isinstance(target, ast.Name)
    } | {s.target.id for s in node.body if isinstance(s, ast.AnnAssign) and isinstance(s.target, ast.Name) and s.value}
    for name in list(cls.names):
        value = cls.names[name]
        is_function = isinstance(value, (PythonFunction, Property, StaticMethod, ClassMethod, PythonClass))
        if name in assigned and not name.startswith("_") and not is_function:
            cls.members[name] = _member(evaluator, cls, name, value, kinds)
            dict.__setitem__(cls.names, name, cls.members[name])


def _member(evaluator: Evaluating, cls: PythonClass, name: str, value: Any, kinds: set[str]) -> Any:
    for other in (cls.members or {}).values():
        if value_of_member(other) == value and type(value_of_member(other)) is type(value):
            return other
    if kinds & {"IntEnum", "IntFlag", "Flag", "int"}:
        return int_member(cls, name, int(value), bool(kinds & {"Flag", "IntFlag"}))
    if kinds & {"StrEnum", "str"}:
        member = TextMember(value)
        member.cls, member.name, member.is_plain = cls, name, "StrEnum" in kinds
        return member
    found = PythonObject(cls, {"name": name, "value": value})
    initialize = cls.find("__init__")
    if initialize is not MISSING:
        evaluator.call(initialize, (found, *(value if isinstance(value, tuple) else (value,))), {})
    return found


def value_of_member(member: Any) -> Any:
    """Return the value of a member of an enumeration."""
    if type(member) is PythonObject:
        return member.fields["value"]
    return int(member) if isinstance(member, IntMember) else str.__str__(member)


AUTO = PythonClass("auto", {}, (object,), None)  # type: ignore[arg-type]


def _make_named_tuple(cls: PythonClass, node: ast.ClassDef) -> None:
    cls.tuple_fields = {name: cls.names.pop(name, MISSING) for name, _ in _annotations(node)}


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
        found = value if type(value) is DataField else DataField(name, value)
        found.name = name
        found.is_keyword = found.is_keyword or is_keyword
        found.is_init_only = annotation.startswith(("InitVar", "dataclasses.InitVar"))
        if type(value) is DataField:
            cls.names.pop(name)
            if found.default is not MISSING:
                cls.names[name] = found.default
        if isinstance(found.default, (list, dict, set)):
            kind = type(found.default)
            raise ValueError(f"mutable default {kind} for field {name} is not allowed: use default_factory")
        fields[name] = found
    cls.data = tuple(fields.values())
    inherited = next((base.options for base in cls.order[1:] if type(base) is PythonClass and base.data), {})
    cls.options |= {key: value for key, value in inherited.items() if key in ("frozen",)} | options
    return cls


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
    if dict in cls.order or list in cls.order:
        return _create_container(evaluator, cls, arguments, named)
    made = PythonObject(cls)
    maker = cls.find("__new__")
    if maker is not MISSING:
        made = evaluator.call(maker.function if isinstance(maker, StaticMethod) else maker, (cls, *arguments), named)
        if type(made) is not PythonObject or made.cls is not cls:
            return made
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


def _create_container(
    evaluator: Evaluating, cls: PythonClass, arguments: tuple[Any, ...], named: dict[str, Any]
) -> DictObject | ListObject:
    made = DictObject() if dict in cls.order else ListObject()
    made.cls, made.fields = cls, {}
    initialize = cls.find("__init__")
    if initialize is not MISSING:
        evaluator.call(initialize, (made, *arguments), named)
    elif isinstance(made, DictObject):
        made.update(*arguments, **named)
    else:
        made.extend(*arguments)
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
    made.cls = cls
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

_METHODS: dict[type, str] = {
    str: "capitalize casefold center count endswith expandtabs find format index isalnum isalpha isascii isdecimal "
    "isdigit isidentifier islower isnumeric isprintable isspace istitle isupper join ljust lower lstrip maketrans "
    "partition removeprefix removesuffix replace rfind rindex rjust rpartition rsplit rstrip split splitlines "
    "startswith strip swapcase title translate upper zfill",
    list: "append clear copy count extend index insert pop remove reverse sort",
    tuple: "count index",
    dict: "clear copy get items keys pop popitem setdefault update values",
    set: "add clear copy difference difference_update discard intersection intersection_update isdisjoint issubset "
    "issuperset pop remove symmetric_difference symmetric_difference_update union update",
    frozenset: "copy difference intersection isdisjoint issubset issuperset symmetric_difference union",
    int: "bit_count bit_length conjugate denominator imag numerator real",
    float: "as_integer_ratio conjugate imag is_integer real",
    complex: "conjugate imag real",
    range: "count index start step stop",
    slice: "indices start step stop",
    Fraction: "denominator limit_denominator numerator",
    deque: "append appendleft clear copy count extend extendleft index insert maxlen pop popleft remove reverse rotate",
    Counter: "clear copy elements get items keys most_common pop popitem setdefault subtract total update values",
    OrderedDict: "clear copy get items keys move_to_end pop popitem setdefault update values",
    ChainMap: "get items keys maps new_child parents pop setdefault update values",
    defaultdict: "clear copy default_factory get items keys pop popitem setdefault update values",
    Match: "end group groupdict groups span start string",
    Pattern: "findall finditer fullmatch match search split sub",
    Random: "betavariate choice choices expovariate gauss getrandbits normalvariate randint random randrange sample "
    "shuffle triangular uniform vonmisesvariate",
    np.random.Generator: "beta binomial chisquare choice dirichlet exponential gamma geometric integers laplace "
    "lognormal multinomial multivariate_normal normal pareto permutation permuted poisson random rayleigh shuffle "
    "standard_exponential standard_normal triangular uniform vonmises weibull",
    np.random.RandomState: "beta binomial chisquare choice dirichlet exponential gamma geometric laplace lognormal "
    "multinomial multivariate_normal normal pareto permutation poisson rand randint randn random random_integers "
    "random_sample rayleigh shuffle standard_exponential standard_normal triangular uniform vonmises weibull",
    np.ndarray: "T all any argmax argmin argsort astype clip conj copy cumprod cumsum diagonal dot dtype fill flat "
    "flatten imag item max mean min ndim nonzero prod ravel real repeat reshape round shape size sort squeeze std sum "
    "swapaxes take tolist trace transpose var",
    np.generic: "all any astype item real imag max mean min round shape size sum tolist ndim dtype T copy",
    BaseException: "args with_traceback add_note value name",
    Template: "safe_substitute substitute template",
}  # fmt: skip
_ALLOWED: dict[type, frozenset[str]] = {kind: frozenset(names.split()) for kind, names in _METHODS.items()}
_VIEWS: tuple[type, ...] = (type({}.keys()), type({}.items()), type({}.values()))
_UNSAFE = "interpreter internals are not available"


def attribute_of(evaluator: Evaluating, value: Any, name: str, default: Any) -> Any:
    """Return an attribute of a value, or the default if there is none; without a default, raises AttributeError."""
    found = _found(evaluator, value, name)
    if found is not MISSING:
        return found
    if default is not UnsupportedPython:
        return default
    if type(value) is Residual:
        raise UnsupportedPython(f"`{name}` of a value of the finished scene is not supported")
    if isinstance(value, Module):
        raise UnsupportedPython(f"`{value.path}.{name}` is not supported")
    kind = type(value) if not isinstance(value, (Native, PythonClass)) else None
    if kind is not None and not hasattr(kind, "cls") and hasattr(kind, name) and not name.startswith("_"):
        raise UnsupportedPython(f"`{name}` of a {type_name(value)} is not supported")
    what = f"type object '{value.name}'" if type(value) is PythonClass else f"'{type_name(value)}' object"
    raise AttributeError(f"{what} has no attribute '{name}'")


def _found(evaluator: Evaluating, value: Any, name: str) -> Any:
    kind = type(value)
    if kind is PythonObject:
        return _of_object(evaluator, value, name)
    if kind is PythonClass:
        return _of_class(evaluator, value, name)
    if kind is Super:
        return _of_super(evaluator, value, name)
    if kind is Module:
        return value.names.get(name, MISSING)
    if kind in (NamedTuple, IntMember, TextMember, DictObject, ListObject):
        own = _of_member(evaluator, value, name)
        if own is not MISSING:
            return own
    if kind in (PythonFunction, Native, BoundMethod):
        return _of_function(evaluator, value, name)
    if kind is Residual:
        return _of_residual(evaluator, value, name)
    if kind is Property:
        return _of_property(value, name)
    if kind is PythonGenerator:
        known = {"send": "send", "close": "close", "__next__": "__next__"}
        return Native(name, getattr(value.steps, known[name])) if name in known else MISSING
    if name.startswith("_"):
        return _special(value, name)
    for each, names in _ALLOWED.items():
        if isinstance(value, each) and name in names:
            return _own_attribute(evaluator, value, name)
    if isinstance(value, _VIEWS) and name in ("isdisjoint",):
        return Native(name, getattr(value, name))
    return MISSING


def _own_attribute(evaluator: Evaluating, value: Any, name: str) -> Any:
    """Return an attribute of one of Python's own values; a method becomes a function of the evaluator."""
    if name == "format":
        return Native(name, lambda *rest, **named: format_text(evaluator, value, rest, named))
    found = getattr(value, name)
    if not callable(found) or isinstance(found, (np.ndarray, np.dtype)):
        return found if not isinstance(found, (type, np.dtype)) else Native(str(found), lambda: found, found)
    if name == "extend" and isinstance(value, list):
        return Native("extend", lambda items: value.extend([items] if is_shape(items) else items))
    if name == "join":
        return Native("join", partial(_joined, value))
    if name in ("center", "expandtabs", "ljust", "replace", "rjust", "zfill"):
        return Native(name, partial(_padded, value, name))
    if name == "astype":
        return Native(name, lambda kind: found(host_type(kind)))
    return Native(name, found)


def _padded(text: str, name: str, *arguments: Any, **named: Any) -> str:
    """Call a method whose result may be much longer than the text."""
    size = len(text) + sum(each for each in arguments if isinstance(each, int))
    if name == "replace":
        size = len(text) + (len(text) + 1) * len(arguments[1])
    elif name == "expandtabs":
        size = len(text) * max(1, *(each for each in arguments if isinstance(each, int)))
    if size > MAX_ITEMS:
        raise UnsupportedPython(f"this text has more than {MAX_ITEMS:,} characters")
    return str(getattr(text, name)(*arguments, **named))


def _joined(separator: Any, items: Iterable[Any]) -> Any:
    parts = list(items)
    if len(separator) * len(parts) + sum(map(len, parts)) > MAX_ITEMS:
        raise UnsupportedPython(f"this text has more than {MAX_ITEMS:,} characters")
    return separator.join(parts)


def host_type(kind: Any) -> Any:
    """Return Python's or numpy's type for a type of the evaluator."""
    return kind.type if type(kind) is Native and kind.type is not None else kind


def _of_object(evaluator: Evaluating, value: PythonObject, name: str) -> Any:
    found = value.cls.find(name)
    if type(found) is Property and not (found.is_cached and name in value.fields):
        result = evaluator.call(found.get, (value,), {})
        if found.is_cached:
            value.fields[name] = result
        return result
    if name in value.fields:
        return value.fields[name]
    if found is not MISSING:
        return _bound(evaluator, found, value, value.cls)
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


_PROTOCOL = {
    "__str__": str, "__repr__": repr, "__len__": len, "__iter__": iter, "__eq__": lambda a, b: a == b, "__hash__": hash,
    "__lt__": lambda a, b: a < b,
}  # fmt: skip


def _protocol(value: Any, name: str) -> Any:
    function = _PROTOCOL.get(name)
    return MISSING if function is None else Native(name, lambda *rest: function(value, *rest))  # type: ignore[operator]


def _bound(evaluator: Evaluating, found: Any, value: Any, cls: PythonClass) -> Any:
    if type(found) is PythonFunction:
        return BoundMethod(found, value, evaluator)
    if type(found) is Native and found.attributes.get("is_method"):
        return BoundMethod(found, value, evaluator)
    if type(found) is ClassMethod:
        return BoundMethod(found.function, cls, evaluator)
    if type(found) is StaticMethod:
        return found.function
    return found


def _of_class(evaluator: Evaluating, cls: PythonClass, name: str) -> Any:
    found = cls.find(name)
    if found is not MISSING:
        if type(found) is ClassMethod:
            return BoundMethod(found.function, cls, evaluator)
        return found.function if type(found) is StaticMethod else found
    if name in ("__name__", "__qualname__"):
        return cls.name
    if name == "__members__" and cls.members is not None:
        return dict(cls.members)
    if name == "__subclasses__":
        raise UnsupportedPython(_UNSAFE, None, "python-forbidden")
    if name in ("__mro__", "__bases__", "__dict__", "__module__"):
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
        return Native(name, lambda cls, *rest, **named: PythonObject(cls))
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
    cls = value.value if type(value.value) is PythonClass else value.value.cls
    order = cls.order
    start = next((i for i, each in enumerate(order) if each is value.cls), -1)
    for each in order[start + 1 :]:
        if type(each) is PythonClass and name in each.names:
            found = each.names[name]
            if type(found) is Property:
                return evaluator.call(found.get, (value.value,), {})
            return _bound(evaluator, found, value.value, cls)
        if type(each) is PythonClass and name == "__init__" and each.data is not None:
            return Native(name, partial(_initialize_as, evaluator, value.value, each))
    if isinstance(value.value, (DictObject, ListObject)):
        host = dict if isinstance(value.value, dict) else list
        if name in _ALLOWED[host] or name in _CONTAINER:
            return Native(name, lambda *rest, **named: getattr(host, name)(value.value, *rest, **named))
    basic = _basic(evaluator, name)
    if basic is not MISSING:
        return basic if name == "__new__" else BoundMethod(basic, value.value, evaluator)
    shown = {"__str__": str, "__repr__": repr}.get(name)
    if shown is not None and cls.is_subclass(BaseException):
        args = value.value.fields.get("args", ())
        return Native(name, lambda: str(args[0]) if len(args) == 1 else str(args))
    return _protocol(value.value, name) if name in ("__eq__", "__hash__") else MISSING


_CONTAINER = (
    "__init__",
    "__getitem__",
    "__setitem__",
    "__delitem__",
    "__contains__",
    "__len__",
    "__iter__",
    "__repr__",
)


def _initialize_as(evaluator: Evaluating, value: PythonObject, cls: PythonClass, *rest: Any, **named: Any) -> None:
    """Initialize the fields that a base class declares."""
    part = PythonObject(cls, value.fields)
    _initialize(evaluator, part, rest, named)


def _of_member(evaluator: Evaluating, value: Any, name: str) -> Any:
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
    elif isinstance(value, (DictObject, ListObject)):
        if name in value.fields:
            return value.fields[name]
    elif name in ("name", "value", "_name_", "_value_"):
        return value.name if "name" in name else value_of_member(value)
    found = value.cls.find(name)
    if type(found) is Property:
        return evaluator.call(found.get, (value,), {})
    if name == "__class__":
        return value.cls
    return MISSING if found is MISSING else _bound(evaluator, found, value, value.cls)


def _of_function(evaluator: Evaluating, value: Any, name: str) -> Any:
    if type(value) is BoundMethod:
        return value.value if name == "__self__" else _of_function(evaluator, value.function, name)
    if name in ("__name__", "__qualname__"):
        return value.name if type(value) is PythonFunction else value.path.rpartition(".")[2]
    if name in value.attributes:
        return value.attributes[name]
    is_numeric = type(value) is Native and value.path.startswith("np.")
    host = getattr(np, value.path.removeprefix("np."), None) if is_numeric else None
    if isinstance(host, np.ufunc) and name in ("accumulate", "at", "outer", "reduce"):
        return Native(f"{value.path}.{name}", getattr(host, name))
    if type(value) is Native and value.path == "object":
        return _basic(evaluator, name)
    if type(value) is Native and isinstance(value.type, type) and not name.startswith("_"):
        if value.type is str and name == "format":
            return Native(name, lambda text, *rest, **named: format_text(evaluator, text, rest, named))
        names = next((_ALLOWED[each] for each in value.type.__mro__ if each in _ALLOWED), frozenset[str]())
        if name in names or (value.type, name) in ((dict, "fromkeys"), (chain, "from_iterable")):
            return Native(name, getattr(value.type, name))
    if type(value) is Native and isinstance(value.type, type) and issubclass(value.type, BaseException):
        return _basic(evaluator, name)
    if name.startswith("__") and name not in ("__doc__", "__wrapped__", "__module__"):
        raise UnsupportedPython(_UNSAFE, None, "python-forbidden")
    return MISSING


def _of_residual(evaluator: Evaluating, value: Residual, name: str) -> Any:
    from scenelang.interpreter.transpile.evaluation.objects import node_of

    if value.kind == "shape":
        return Native(name, lambda: value) if name == "copy" else MISSING
    if name == "T":
        return Residual(ast.Attribute(node_of(value), "T", ast.Load()), value.kind, value.holder)
    if name in ("copy", "tolist", "sum", "min", "max", "mean", "astype", "dot"):
        kind = value.kind if name in ("copy", "tolist", "astype") else "number"

        def method(*arguments: Any) -> Residual:
            nodes = [node_of(each) for each in arguments if type(each) is not Native]
            return Residual(ast.Call(ast.Attribute(node_of(value), name, ast.Load()), nodes, []), kind, value.holder)

        return Native(name, method) if name != "astype" else Native(name, lambda kind: value)
    return MISSING


def _of_property(value: Property, name: str) -> Any:
    if name == "setter":
        return Native(name, lambda function: Property(value.get, function, value.delete))
    if name == "deleter":
        return Native(name, lambda function: Property(value.get, value.set, function))
    if name == "getter":
        return Native(name, lambda function: Property(function, value.set, value.delete))
    return MISSING


def _special(value: Any, name: str) -> Any:
    if name == "__cause__" and isinstance(value, BaseException):
        return value.__cause__
    if name == "__class__":
        return Native(type(value).__name__, lambda: None, type(value))
    if name in ("__enter__", "__exit__") and hasattr(value, name):
        return Native(name, getattr(value, name))
    if name in ("__len__", "__iter__", "__getitem__", "__contains__", "__add__", "__mul__", "__eq__", "__next__"):
        return Native(name, getattr(value, name)) if hasattr(value, name) else MISSING
    if name.startswith("__") and hasattr(type(value), name):
        raise UnsupportedPython(_UNSAFE, None, "python-forbidden")
    return MISSING


def set_attribute(evaluator: Evaluating, value: Any, name: str, new: Any) -> None:
    """Assign an attribute of a value."""
    if type(value) is PythonObject:
        found = value.cls.find(name)
        if type(found) is Property and not found.is_cached:
            if found.set is None:
                raise AttributeError(f"property '{name}' of '{value.cls.name}' object has no setter")
            evaluator.call(found.set, (value, new), {})
            return
        own = value.cls.find("__setattr__")
        if own is not MISSING:
            evaluator.call(own, (value, name, new), {})
            return
        if value.cls.options.get("frozen") or (value.cls.members is not None and name in ("name", "value")):
            raise AttributeError(f"cannot assign to field '{name}'")
        value.fields[name] = new
    elif isinstance(value, (DictObject, ListObject)):
        value.fields[name] = new
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

    class Safe(Formatter):
        def get_field(self, field_name: str, args: Any, kwargs: Any) -> Any:
            first, rest = _split(field_name)
            value = self.get_value(first, args, kwargs)
            for is_attribute, name in rest:
                value = evaluator.attribute(value, name) if is_attribute else value[name]
            return value, first

        def format_field(self, value: Any, format_spec: str) -> Any:
            return formatted(value, format_spec)

    return Safe().vformat(text, arguments, named)


def _split(field: str) -> tuple[int | str, list[tuple[bool, str]]]:
    from _string import formatter_field_name_split  # type: ignore[import-not-found]

    first, rest = formatter_field_name_split(field)
    return first, list(rest)


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
        copied.cls = value.cls
        return copied
    if type(value) is list:
        items: list[Any] = []
        memo[id(value)] = items
        items += [deep_copy(each, memo) for each in value]
        return items
    if isinstance(value, dict):
        found = value.copy()
        found.clear()
        memo[id(value)] = found
        found.update({deep_copy(key, memo): deep_copy(each, memo) for key, each in value.items()})
        return found
    if type(value) in (tuple, set, deque):
        return type(value)(deep_copy(each, memo) for each in value)
    return value.copy() if isinstance(value, np.ndarray) else value


def shallow_copy(value: Any) -> Any:
    """Copy a value."""
    if type(value) is PythonObject:
        method = value.method("__copy__")
        return method() if method is not None else PythonObject(value.cls, dict(value.fields))
    return value.copy() if isinstance(value, (list, dict, set, deque, np.ndarray)) else value
