"""Values of the evaluator of Python: functions, classes and instances of the program, and residual values.

Numbers, texts, containers and arrays are Python's and numpy's own. Instances of the program's classes implement the
protocols of Python by calling the program's methods, so that functions such as ``sorted`` treat them as Python does.
"""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable, Generator, Iterator, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from types import MethodType
from typing import Any, Protocol

from scenelang.interpreter.transpile.evaluation import UnsupportedPython, words


class Raised(Exception):
    """Exception of the program whose class the program defines."""

    def __init__(self, value: PythonObject) -> None:
        super().__init__(*value.fields.get("args", ()))
        self.value = value


class Exhausted(Exception):
    """``StopIteration`` of the program, which may not pass through the host's generators."""

    def __init__(self, value: Any = None) -> None:
        super().__init__()
        self.value = StopIteration() if value is None else StopIteration(value)


def value_of_error(error: Exception) -> Any:
    """Return the exception that the program sees."""
    return error.value if isinstance(error, (Raised, Exhausted)) else error


class Caller(Protocol):
    """What values need of the evaluator."""

    def call(self, function: Any, arguments: tuple[Any, ...], named: dict[str, Any]) -> Any:
        """Call a value."""
        ...

    def metered(self, items: Any) -> Any:
        """Return an iterator whose items are steps."""
        ...


class Evaluating(Caller, Protocol):
    """What the classes of the program need of the evaluator."""

    modules: Mapping[str, Module]
    builtins: dict[str, Any]
    types: dict[type, Native]
    loops: Any

    def iterate(self, value: Any) -> Iterator[Any]:
        """Iterate over a value; every item is a step."""
        ...

    def spread(self, shape: Any) -> list[Any]:
        """Return a shape for a list to which its primitives are added."""
        ...

    def tick(self, count: int = 1) -> None:
        """Count steps."""
        ...

    def mixin(self, name: str) -> Any:
        """Return a class of ``collections.abc`` with its methods, None for another name."""
        ...

    def eval(self, node: ast.expr, frame: Frame) -> Any:
        """Evaluate an expression."""
        ...

    def execute(self, body: list[ast.stmt], frame: Frame) -> Generator[Any, Any, Any]:
        """Evaluate statements; iterate over what they yield."""
        ...

    def attribute(self, value: Any, name: str, default: Any = ...) -> Any:
        """Return an attribute of a value."""
        ...


# --- scopes and functions ------------------------------------------------------------------------------------------


@dataclass(slots=True, eq=False)
class Frame:
    """Variables of a call, a class body, a comprehension or the module (``outer`` is None).

    ``local`` names are assigned in it, ``shared`` ones are declared global (True) or nonlocal (False).
    """

    names: dict[str, Any]
    outer: Frame | None
    local: frozenset[str] = frozenset()
    shared: dict[str, bool] = field(default_factory=dict)
    is_comprehension: bool = False
    is_class: bool = False
    function: PythonFunction | None = None
    first: Any = None  # the first argument, for `super()`


@dataclass(slots=True, eq=False)
class PythonFunction:
    """Function or lambda expression of the program."""

    node: ast.FunctionDef | ast.Lambda
    name: str
    outer: Frame
    caller: Caller
    defaults: tuple[Any, ...] = ()
    keyword_defaults: dict[str, Any] = field(default_factory=dict)
    owner: PythonClass | None = None
    attributes: dict[str, Any] = field(default_factory=dict)

    @property
    def qualified(self) -> str:
        """Name with those of the class and of the functions around it."""
        if self.owner is not None:
            return f"{self.owner.name}.{self.name}"
        around = self.outer.function
        return self.name if around is None else f"{around.qualified}.<locals>.{self.name}"

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        return self.caller.call(self, arguments, named)


@dataclass(slots=True, eq=False)
class BoundMethod:
    """Method of a value."""

    function: Any
    value: Any
    caller: Caller

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        return self.caller.call(self.function, (self.value, *arguments), named)

    def __eq__(self, other: object) -> bool:
        return type(other) is BoundMethod and other.function is self.function and other.value is self.value

    def __hash__(self) -> int:
        return hash((id(self.function), id(self.value)))


@dataclass(slots=True, eq=False)
class Native:
    """Function or type of Python or a library.

    Attributes
    ----------
    path
        Dotted name.
    function
        Function that is called.
    type
        Type for ``isinstance``, if it is one.
    is_numeric
        Whether a call with residual arguments can be left to the program.
    """

    path: str
    function: Callable[..., Any]
    type: Any = None
    is_numeric: bool = False
    attributes: dict[str, Any] = field(default_factory=dict)

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        return self.function(*arguments, **named)

    def __eq__(self, other: object) -> bool:
        is_type = type(other) is Native and self.type is not None and other.type is not None
        return self is other or (is_type and bool(self.type == other.type))  # type: ignore[attr-defined]

    def __hash__(self) -> int:
        return id(self) >> 4 if self.type is None else hash(self.type)

    def __repr__(self) -> str:
        return f"<class '{self.path}'>" if self.type is not None else f"<built-in function {self.path}>"


def refused(error: UnsupportedPython) -> Native:
    """Return what an import binds that is not supported; it is an error when it is used."""

    def refuse(*_: Any, **__: Any) -> Any:
        raise UnsupportedPython(error.message, error.hint, error.name)

    return Native("refused", refuse, attributes={"__refused__": refuse})


@dataclass(slots=True, eq=False)
class Module:
    """Module of a library, with the names that may be used."""

    path: str
    names: dict[str, Any]


class HostObject:
    """Value of a library that a domain models; programs see the attributes that it names, and no others.

    ``shown`` are attributes and methods that programs may read. A domain whose values decide by themselves overrides
    ``read`` and ``assign``.
    """

    shown: frozenset[str] = frozenset()

    def read(self, name: str) -> Any:
        """Return an attribute, MISSING if there is none."""
        if name not in self.shown:
            return MISSING
        value = getattr(self, name)
        return Native(name, value) if isinstance(value, MethodType) else value

    def assign(self, name: str, value: Any) -> None:
        """Assign an attribute."""
        raise UnsupportedPython(f"`{name}` of a {type_name(self)} cannot be assigned")


@dataclass(slots=True, eq=False)
class Property:
    """Property of a class; ``is_cached`` for ``cached_property``."""

    get: Any
    set: Any = None
    delete: Any = None
    is_cached: bool = False


class Cache(dict[Any, Any]):
    """Results of a function that is cached: that there are more of them changes nothing that a program can see."""


@dataclass(slots=True, eq=False)
class StaticMethod:
    """Function of a class without a bound argument."""

    function: Any


@dataclass(slots=True, eq=False)
class ClassMethod:
    """Function of a class that is bound to the class."""

    function: Any


@dataclass(slots=True, eq=False)
class Super:
    """Result of ``super()``: the classes after ``cls``, for a value."""

    cls: PythonClass
    value: Any


@dataclass(slots=True, eq=False)
class PythonGenerator:
    """Generator of the program."""

    steps: Generator[Any, Any, Any]
    name: str

    def __iter__(self) -> PythonGenerator:
        return self

    def __next__(self) -> Any:
        return next(self.steps)


# --- classes and instances -----------------------------------------------------------------------------------------


MISSING: Any = type("Missing", (), {"__repr__": lambda self: "MISSING"})()


@dataclass(slots=True, eq=False)
class DataField:
    """Field of a dataclass."""

    name: str
    default: Any = MISSING
    factory: Any = MISSING
    in_init: bool = True
    in_repr: bool = True
    in_compare: bool = True
    is_keyword: bool = False
    is_init_only: bool = False


@dataclass(slots=True, eq=False)
class PythonClass:
    """Class of the program.

    Attributes
    ----------
    order
        Method resolution order: classes of the program, then Python's.
    members
        Members of an enumeration by name.
    data
        Fields of a dataclass, None for another class.
    tuple_fields
        Fields of a named tuple with their defaults, None for another class.
    """

    name: str
    names: dict[str, Any]
    bases: tuple[Any, ...]
    caller: Caller
    order: tuple[Any, ...] = ()
    members: dict[str, Any] | None = None
    data: tuple[DataField, ...] | None = None
    options: dict[str, Any] = field(default_factory=dict)
    tuple_fields: dict[str, Any] | None = None
    is_total: bool = False

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        return self.caller.call(self, arguments, named)

    def __iter__(self) -> Iterator[Any]:
        if self.members is None:
            raise TypeError("'type' object is not iterable")
        members = dict.fromkeys(self.members.values())
        is_flag = any(type(each) is IntMember and each.is_flag for each in members)
        return iter([m for m in members if m.bit_count() == 1] if is_flag else members)  # others are aliases

    def __reversed__(self) -> Iterator[Any]:
        return iter([*self][::-1])

    def __len__(self) -> int:
        if self.members is None:
            raise TypeError("object of type 'type' has no len()")
        return sum(1 for _ in self)

    def __bool__(self) -> bool:
        return True

    def __contains__(self, value: Any) -> bool:
        return any(value is member for member in self)

    def __getitem__(self, name: Any) -> Any:
        return self if self.members is None else self.members[name]  # a generic class is itself

    def find(self, name: str) -> Any:
        """Return an attribute of the class or its bases, else MISSING."""
        for cls in self.order:
            if type(cls) is PythonClass and name in cls.names:
                return cls.names[name]
        return MISSING

    def is_subclass(self, other: Any) -> bool:
        """Return whether it is another class or derived from it."""
        if isinstance(other, type):
            return any(isinstance(cls, type) and issubclass(cls, other) for cls in self.order)
        return any(cls is other for cls in self.order)


def linearized(cls: PythonClass) -> tuple[Any, ...]:
    """Return the method resolution order of a class (C3, as Python's)."""
    orders = [list(base.order) if type(base) is PythonClass else list(base.__mro__) for base in cls.bases]
    pending = [*orders, list(cls.bases)]
    order: list[Any] = [cls]
    while any(pending):
        pending = [each for each in pending if each]
        for each in pending:
            if not any(any(item is each[0] for item in other[1:]) for other in pending):
                break
        else:
            raise TypeError("Cannot create a consistent method resolution order (MRO)")
        head = each[0]
        order.append(head)
        pending = [other[1:] if other[0] is head else other for other in pending]
    return tuple(order) if order[-1] is object else (*order, object)


@dataclass(slots=True, eq=False)
class PythonObject:
    """Instance of a class of the program."""

    cls: PythonClass
    fields: dict[str, Any] = field(default_factory=dict)
    is_general: bool = False  # whether it stands for another object in every turn of a loop

    def method(self, name: str) -> Any:
        """Return a bound method, else None."""
        function = self.cls.find(name)
        return None if function is MISSING or function is None else BoundMethod(function, self, self.cls.caller)

    def own_fields(self) -> dict[str, Any]:
        """Return the fields without the values of cached properties, which follow from the others."""
        return {
            name: value for name, value in self.fields.items()
            if not (type(attribute := self.cls.find(name)) is Property and attribute.is_cached)
        }  # fmt: skip

    def compared(self) -> tuple[Any, ...] | None:
        """Return the values of a dataclass that are compared, else None."""
        if self.cls.data is None or not self.cls.options.get("eq", True):
            return None
        return tuple(self.fields[each.name] for each in self.cls.data if each.in_compare and not each.is_init_only)

    def __eq__(self, other: object) -> Any:
        method = self.method("__eq__")
        if method is not None:
            return method(other)
        values = self.compared()
        if values is not None and type(other) is PythonObject and other.cls is self.cls:
            return values == other.compared()
        return True if same(self, other) else NotImplemented

    def __ne__(self, other: object) -> Any:
        method = self.method("__ne__")
        if method is not None:
            return method(other)
        result = self.__eq__(other)
        return result if result is NotImplemented else not result

    def __hash__(self) -> int:
        method = self.method("__hash__")
        if method is not None:
            return int(method())
        if self.cls.find("__eq__") is not MISSING:
            raise TypeError(f"unhashable type: '{self.cls.name}'")
        values = self.compared()
        if values is None:
            return id(self) >> 4 if not self.is_general else same(self, None)
        if not self.cls.options.get("frozen") and not self.cls.options.get("unsafe_hash"):
            raise TypeError(f"unhashable type: '{self.cls.name}'")
        return hash(values)

    def __bool__(self) -> bool:
        for name in ("__bool__", "__len__"):
            method = self.method(name)
            if method is not None:
                return bool(method())
        return True

    def __len__(self) -> int:
        return int(self._required("__len__", f"object of type '{self.cls.name}' has no len()")())

    def __iter__(self) -> Iterator[Any]:
        method = self.method("__iter__")
        if method is not None:
            iterator = method()
            return iterator if type(iterator) is PythonObject else self.cls.caller.metered(iter(iterator))
        return self._items(self._required("__getitem__", f"'{self.cls.name}' object is not iterable"))

    @staticmethod
    def _items(get: Callable[[int], Any]) -> Iterator[Any]:
        index = 0
        while True:
            try:
                yield get(index)
            except IndexError:
                return
            index += 1

    def __next__(self) -> Any:
        method = self._required("__next__", f"'{self.cls.name}' object is not an iterator")
        try:
            return method()
        except Exhausted:
            raise StopIteration from None

    def __reversed__(self) -> Iterator[Any]:
        method = self.method("__reversed__")
        return iter(method()) if method is not None else iter([self[i] for i in reversed(range(len(self)))])

    def __getitem__(self, index: Any) -> Any:
        return self._required("__getitem__", f"'{self.cls.name}' object is not subscriptable")(index)

    def __setitem__(self, index: Any, value: Any) -> None:
        message = f"'{self.cls.name}' object does not support item assignment"
        self._required("__setitem__", message)(index, value)

    def __delitem__(self, index: Any) -> None:
        self._required("__delitem__", f"'{self.cls.name}' object doesn't support item deletion")(index)

    def __contains__(self, value: Any) -> bool:
        method = self.method("__contains__")
        return bool(method(value)) if method is not None else any(value is item or value == item for item in self)

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        return self._required("__call__", f"'{self.cls.name}' object is not callable")(*arguments, **named)

    def __index__(self) -> int:
        message = f"'{self.cls.name}' object cannot be interpreted as an integer"
        return int(self._required("__index__", message)())

    def __int__(self) -> int:
        method = self.method("__int__") or self._required("__index__", f"not a number: '{self.cls.name}'")
        return int(method())

    def __float__(self) -> float:
        message = f"float() argument must be a string or a real number, not '{self.cls.name}'"
        return float(self._required("__float__", message)())

    def __str__(self) -> str:
        method = self.method("__str__")
        if method is not None:
            return str(method())
        if "args" in self.fields and self.cls.is_subclass(BaseException):
            args = self.fields["args"]
            return str(args[0]) if len(args) == 1 else str(args) if args else ""
        return repr(self) if self.cls.members is None else f"{self.cls.name}.{self.fields['name']}"

    def __repr__(self) -> str:
        method = self.method("__repr__")
        if method is not None:
            return str(method())
        if self.cls.data is not None:
            shown = (
                f"{each.name}={self.fields[each.name]!r}"
                for each in self.cls.data
                if each.in_repr and not each.is_init_only
            )
            return f"{self.cls.name}({', '.join(shown)})"
        if self.cls.members is not None:
            return f"<{self.cls.name}.{self.fields['name']}: {self.fields['value']!r}>"
        if "args" in self.fields:
            return f"{self.cls.name}({', '.join(map(repr, self.fields['args']))})"
        raise UnsupportedPython(f"the text of an instance of `{self.cls.name}` contains its address in memory")

    def __format__(self, specification: str) -> str:
        method = self.method("__format__")
        return str(method(specification)) if method is not None else format(str(self), specification)

    def _required(self, name: str, message: str) -> BoundMethod:
        method: BoundMethod | None = self.method(name)
        if method is None:
            raise TypeError(message)
        return method


def _binary(name: str) -> Callable[[PythonObject, Any], Any]:
    def operation(self: PythonObject, other: Any) -> Any:
        method = self.method(f"__{name}__")
        return NotImplemented if method is None else method(other)

    return operation


def _unary(name: str) -> Callable[..., Any]:
    def operation(self: PythonObject, *arguments: Any) -> Any:
        return self._required(f"__{name}__", f"bad operand type: '{self.cls.name}'")(*arguments)

    return operation


_COMPARISONS = {"lt": operator.lt, "le": operator.le, "gt": operator.gt, "ge": operator.ge}


def _comparison(name: str) -> Callable[[PythonObject, Any], Any]:
    def operation(self: PythonObject, other: Any) -> Any:
        method = self.method(f"__{name}__")
        if method is not None:
            return method(other)
        is_same = type(other) is PythonObject and other.cls is self.cls
        if is_same and self.cls.data is not None and self.cls.options.get("order"):
            return _COMPARISONS[name](self.compared() or (), other.compared() or ())
        is_total = any(type(cls) is PythonClass and cls.is_total for cls in self.cls.order)
        return _by_total_order(self, name, other) if is_total else NotImplemented

    return operation


def _by_total_order(value: PythonObject, name: str, other: Any) -> Any:
    """Compare as ``functools.total_ordering`` does, by the first comparison that the class defines."""
    for given in ("lt", "le", "gt", "ge"):
        method = value.method(f"__{given}__")
        if method is None:
            continue
        result = method(other)
        if result is NotImplemented:
            return result
        is_strict, wants_strict = given in ("lt", "gt"), name in ("lt", "gt")
        if given[0] == name[0]:
            return result and value != other if wants_strict else result or value == other
        return (
            (not result and (value != other if is_strict else True))
            if wants_strict
            else (not result if is_strict else not result or value == other)
        )
    return NotImplemented


_BINARY = words(
    "divmod rdivmod add sub mul truediv floordiv mod pow matmul and or xor lshift rshift radd rsub rmul rtruediv "
    "rfloordiv rmod rpow rmatmul rand ror rxor rlshift rrshift iadd isub imul "
    "itruediv ifloordiv imod ipow imatmul iand ior ixor"
)
for _name in _BINARY:
    setattr(PythonObject, f"__{_name}__", _binary(_name))
for _name in ("neg", "pos", "invert", "abs", "round", "floor", "ceil", "trunc"):
    setattr(PythonObject, f"__{_name}__", _unary(_name))
for _name in _COMPARISONS:
    setattr(PythonObject, f"__{_name}__", _comparison(_name))
PythonObject.__array_ufunc__ = None  # type: ignore[attr-defined]  # numpy leaves operations to the methods above


class ValueObject:
    """What instances of the program's classes derived from Python's own types share."""

    cls: PythonClass
    fields: dict[str, Any]
    host: type

    def own(self, name: str) -> Any:
        """Return a bound method of the program's class, else None."""
        function = self.cls.find(name)
        return None if function is MISSING else BoundMethod(function, self, self.cls.caller)

    def plain(self) -> Any:
        """Return the value as one of Python's type."""
        host: Any = self.host
        if issubclass(host, (tuple, list, str, bytes)):
            return host.__getitem__(self, slice(None))
        return host.__pos__(self) if issubclass(host, (int, float, complex)) else host.copy(self)


def _value_operation(host: Any, name: str) -> Callable[..., Any]:
    inherited = getattr(host, name, None)

    def operation(self: Any, *arguments: Any) -> Any:
        method = self.own(name)
        if method is not None:
            result = method(*arguments)
            return self.cls.caller.metered(iter(result)) if name == "__iter__" else result
        return NotImplemented if inherited is None else inherited(self, *arguments)

    return operation


_BINARY_METHODS = (*(f"__{_name}__" for _name in _BINARY if _name[0] != "i"), "__iter__")
_VALUE_METHODS = words(
    "__getitem__ __setitem__ __delitem__ __contains__ __iter__ __len__ __repr__ __str__ __format__ __bool__ __neg__ "
    "__pos__ __abs__ __invert__ __round__ __hash__ __eq__ __ne__ __lt__ __le__ __gt__ __ge__ __reversed__ __iadd__ "
    "__call__ __missing__"
)


@lru_cache(maxsize=100)
def value_type(host: type) -> Any:
    """Return the type of instances of classes of the program that are derived from one of Python's types."""
    made: Any = type("ValueObject", (ValueObject, host), {"host": host})
    for name in (*_VALUE_METHODS, *_BINARY_METHODS):
        if getattr(host, name, None) is not None or name in _BINARY_METHODS[:-1]:
            setattr(made, name, _value_operation(host, name))
    if issubclass(host, dict):
        made.__missing__ = _missing
    return made


def _missing(self: Any, key: Any) -> Any:
    method = self.own("__missing__")
    if method is not None:
        return method(key)
    if getattr(self, "default_factory", None) is None:
        raise KeyError(key)
    self[key] = default = self.default_factory()
    return default


class NamedTuple(value_type(tuple)):  # type: ignore[misc]
    """Instance of a named tuple of the program."""

    def __repr__(self) -> str:
        method = self.own("__repr__")
        if method is not None:
            return str(method())
        shown = (f"{name}={value!r}" for name, value in zip(self.cls.tuple_fields or (), self))
        return f"{self.cls.name}({', '.join(shown)})"

    def __str__(self) -> str:
        method = self.own("__str__")
        return repr(self) if method is None else str(method())

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        return self.cls.caller.call(self.own("__call__"), arguments, named)


class IntMember(int):
    """Member of an enumeration that is an integer, or of flags."""

    cls: PythonClass
    name: str | None
    is_flag: bool

    def __repr__(self) -> str:
        return f"<{self.cls.name}{'.' + self.name if self.name else ''}: {int(self)}>"

    def __str__(self) -> str:
        own = self.cls.find("__str__")
        if own is not MISSING:
            return str(self.cls.caller.call(own, (self,), {}))
        if self.cls.options["kinds"] & {"IntEnum", "IntFlag"}:
            return str(int(self))
        return f"{self.cls.name}.{self.name}" if self.name else f"{self.cls.name}({int(self)})"

    def __format__(self, specification: str) -> str:
        is_number = self.cls.options["kinds"] & {"IntEnum", "IntFlag"} and self.cls.find("__str__") is MISSING
        return format(int(self) if is_number else str(self), specification)

    def _combined(self, value: int) -> IntMember:
        for member in (self.cls.members or {}).values():
            if int(member) == value:
                combined: IntMember = member
                return combined
        named = [m.name for m in self.cls if m.name and int(m) and int(m) & value == int(m)]
        return int_member(self.cls, "|".join(named) or None, value, True)


def _flag_operation(name: str) -> Callable[[IntMember, Any], Any]:
    inherited = getattr(int, f"__{name}__")

    def operation(self: IntMember, other: Any) -> Any:
        result = inherited(int(self), int(other)) if isinstance(other, int) else NotImplemented
        return self._combined(result) if self.is_flag and result is not NotImplemented else result

    return operation


for _name in ("and", "or", "xor", "rand", "ror", "rxor"):
    setattr(IntMember, f"__{_name}__", _flag_operation(_name))


def _inverted(self: IntMember) -> Any:
    everything = 0
    for member in self.cls:
        everything |= int(member)
    return self._combined(everything & ~int(self)) if self.is_flag else ~int(self)


def _contains(self: IntMember, other: Any) -> bool:
    return int(other) & int(self) == int(other)


def _parts(self: IntMember) -> Iterator[Any]:
    return iter([m for m in self.cls if int(m) and int(m) & int(self) == int(m)])


for _name, _method in (("invert", _inverted), ("contains", _contains), ("iter", _parts)):
    setattr(IntMember, f"__{_name}__", _method)


def int_member(cls: PythonClass, name: str | None, value: int, is_flag: bool) -> IntMember:
    """Create a member of an enumeration of integers."""
    member = IntMember(value)
    member.cls, member.name, member.is_flag = cls, name, is_flag
    return member


class TextMember(str):
    """Member of an enumeration that is a text; ``is_plain`` for ``StrEnum``, which is shown as its value."""

    cls: PythonClass
    name: str
    is_plain: bool

    def __repr__(self) -> str:
        return f"<{self.cls.name}.{self.name}: {str.__str__(self)!r}>"

    def __str__(self) -> str:
        own = self.cls.find("__str__")
        if own is not MISSING:
            return str(self.cls.caller.call(own, (self,), {}))
        return str.__str__(self) if self.is_plain else f"{self.cls.name}.{self.name}"

    def __format__(self, specification: str) -> str:
        return format(str(self), specification)

    def __hash__(self) -> int:
        return str.__hash__(self)


# --- identity and names ---------------------------------------------------------------------------------------------


class Unroll(BaseException):
    """Raised where a loop cannot remain a loop, or a function not one for all arguments; ``place`` is its node.

    ``around`` are the nodes of the loops and functions around it. No ``place`` stands for the innermost one;
    ``is_again`` tells that the next evaluation knows more; ``parameters`` are those of a function to be known.
    """

    def __init__(
        self,
        place: ast.AST | None = None,
        around: tuple[ast.AST, ...] = (),
        is_again: bool = False,
        parameters: frozenset[str] = frozenset(),
    ) -> None:
        super().__init__()
        self.place, self.around, self.parameters = place, around, parameters
        self.is_final = place is not None or is_again


def same(value: PythonObject, other: Any) -> Any:
    """Return whether two values are the same object. Raises Unroll if another turn of a loop may tell otherwise."""
    if value is other:
        return True
    if value.is_general or (type(other) is PythonObject and other.is_general):
        raise Unroll
    return False


def type_name(value: Any) -> str:
    """Return the name of the type of a value, as Python calls it."""
    if isinstance(value, (PythonObject, ValueObject, IntMember, TextMember)):
        return value.cls.name
    if type(value) is Native and value.type is not None:
        return "type"
    names: dict[type, str] = {
        PythonFunction: "function", BoundMethod: "method", Native: "builtin_function_or_method", PythonClass: "type",
        Module: "module", PythonGenerator: "generator",
    }  # fmt: skip
    return names.get(type(value)) or str(getattr(type(value), "python_name", type(value).__name__))


# --- calls and texts ---------------------------------------------------------------------------------------------


def renamed(error: TypeError, *values: Any) -> TypeError:
    """Return an error of the host with the names that the program knows the types of some values by."""
    text = str(error)
    for value in values:
        for quote in "'\"":
            name, shown = f"{quote}{type(value).__name__}{quote}", f"{quote}{type_name(value)}{quote}"
            if name != shown and name in text:
                text = text.replace(name, shown, 1)
                break
    return error if text == str(error) else TypeError(text)


def delete_attribute(evaluator: Caller, owner: Any, name: str) -> None:
    """Delete an attribute of a value."""
    if type(owner) is PythonClass and name in owner.names:
        del owner.names[name]
        return
    if type(owner) is not PythonObject:
        raise UnsupportedPython("only attributes of the program's own objects can be deleted")
    attribute = owner.cls.find(name)
    if type(attribute) is Property and attribute.delete is not None:
        evaluator.call(attribute.delete, (owner,), {})
    elif owner.fields.pop(name, MISSING) is MISSING:
        raise AttributeError(f"'{owner.cls.name}' object has no attribute '{name}'")


class Metered:
    """Iterator whose items are steps."""

    def __init__(self, evaluator: Evaluating, items: Iterator[Any]) -> None:
        self._evaluator, self.items = evaluator, items

    def __iter__(self) -> Metered:
        return self

    def __next__(self) -> Any:
        self._evaluator.tick()
        return next(self.items)
