"""Evaluation of Python during the translation, by an interpreter of its syntax tree that never executes Python.

What the translation proper does not support is evaluated here (``folding``); the rest of the program stays as it is.
"""

from __future__ import annotations

import ast
import operator
import re
from collections import ChainMap, Counter, OrderedDict, defaultdict, deque
from collections.abc import Callable, Iterable, Mapping
from fractions import Fraction
from random import Random
from re import Match, Pattern
from string import Template
from typing import Any

import numpy as np

from scenelang.interpreter.transpile.evaluation.deterministic import PARSER


def words(text: str) -> tuple[str, ...]:
    """Return the words of a text; long lists of names are easier to read so."""
    return tuple(text.split())


MAX_ITEMS, MAX_BITS = 2_000_000, 20_000  # of a container or text, of an integer


class UnsupportedPython(Exception):
    """Raised for Python that cannot be evaluated; ``node`` is its place once it is known."""

    def __init__(self, message: str, hint: str | None = None, name: str = "python-unsupported") -> None:
        super().__init__(message)
        self.message, self.hint, self.name = message, hint, name
        self.node: ast.AST | None = None
        self.because: tuple[Any, ...] = ()  # values that are not known, where these are the reason


class NeedsPrimitives(Exception):
    """Raised where it makes a difference that a list contains a shape instead of its primitives."""


# The methods of Python's and numpy's types that programs may use.

_METHODS: dict[type, str] = {
    bytes: "count decode endswith find hex index join split startswith",
    bytearray: "append decode extend hex",
    str: "capitalize casefold center count encode endswith expandtabs find format index isalnum isalpha "
    "isascii isdecimal isdigit isidentifier islower isnumeric isprintable isspace istitle isupper join ljust lower "
    "lstrip maketrans partition removeprefix removesuffix replace rfind rindex rjust rpartition rsplit rstrip split "
    "splitlines startswith strip swapcase title translate upper zfill",
    list: "append clear copy count extend index insert pop remove reverse sort",
    tuple: "count index",
    dict: "clear copy get items keys pop popitem setdefault update values",
    set: "add clear copy difference difference_update discard intersection intersection_update isdisjoint issubset "
    "issuperset pop remove symmetric_difference symmetric_difference_update union update",
    frozenset: "copy difference intersection isdisjoint issubset issuperset symmetric_difference union",
    int: "bit_count bit_length conjugate denominator from_bytes imag numerator real",
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
    Random: "betavariate choice choices expovariate gammavariate gauss getrandbits getstate lognormvariate "
    "normalvariate paretovariate randint random randrange sample seed setstate shuffle triangular uniform "
    "vonmisesvariate weibullvariate",
    np.random.Generator: "beta binomial chisquare choice dirichlet exponential gamma geometric integers laplace "
    "logistic lognormal multinomial multivariate_normal negative_binomial normal pareto permutation permuted poisson "
    "power random rayleigh shuffle standard_cauchy standard_exponential standard_gamma standard_normal standard_t "
    "triangular uniform vonmises wald weibull zipf",
    np.random.RandomState: "beta binomial chisquare choice dirichlet exponential gamma geometric laplace lognormal "
    "logistic multinomial multivariate_normal negative_binomial normal pareto permutation poisson power rand randint "
    "randn random random_integers random_sample rayleigh seed shuffle standard_cauchy standard_exponential "
    "standard_gamma standard_normal standard_t triangular uniform vonmises wald weibull zipf",
    np.ndarray: "T all any argmax argmin argsort astype clip conj copy cumprod cumsum diagonal dot dtype fill flat "
    "flatten imag item max mean min ndim nonzero prod ravel real repeat reshape round shape size sort squeeze std sum "
    "swapaxes take tobytes tolist trace transpose var",
    np.generic: "all any astype item real imag max mean min round shape size sum tolist ndim dtype T copy",
    BaseException: "args with_traceback add_note value name",
    Template: "safe_substitute substitute template",
}  # fmt: skip
METHODS: dict[type, frozenset[str]] = {kind: frozenset(names.split()) for kind, names in _METHODS.items()}

# The names of numpy that programs may use; what makes large arrays of small arguments.

NUMPY = words(
    "abs absolute add all allclose any append arange arccos arccosh arcsin arcsinh arctan arctan2 arctanh argmax "
    "argmin argsort argwhere around array array_equal array_split asarray atleast_1d atleast_2d average bincount "
    "broadcast_arrays broadcast_to ceil clip column_stack concatenate copy copysign corrcoef cos cosh "
    "count_nonzero cov cross cumprod cumsum deg2rad degrees delete diag diagonal diff digitize divide dot dstack "
    "ediff1d einsum empty empty_like equal exp exp2 expand_dims expm1 eye fabs flatnonzero flip fliplr flipud "
    "float_power floor floor_divide fmax fmin fmod full full_like gcd geomspace gradient greater greater_equal "
    "histogram hsplit hstack hypot identity in1d indices inner insert interp intersect1d invert isclose isfinite "
    "isin isinf isnan ix_ kron lcm less less_equal lexsort linspace log log10 log1p log2 logical_and logical_not "
    "logical_or logical_xor logspace matmul max maximum mean median meshgrid min minimum mod moveaxis multiply "
    "nan_to_num nanmax nanmean nanmin nansum ndenumerate ndindex ndim negative nonzero not_equal ones ones_like "
    "outer pad percentile piecewise poly1d polyfit polyval power prod ptp quantile rad2deg radians ravel "
    "reciprocal repeat reshape resize rint roll rollaxis rot90 round searchsorted select setdiff1d sign sin sinc "
    "sinh size sort split sqrt square squeeze stack std subtract sum swapaxes take tan tanh tensordot tile trace "
    "transpose trapz tri tril triu true_divide trunc union1d unique unravel_index var vdot vectorize vsplit "
    "vstack where zeros zeros_like apply_along_axis tril_indices triu_indices diag_indices unwrap shape fromiter "
    "fromfunction fill_diagonal put_along_axis take_along_axis full_like copyto block convolve "
    "triu_indices_from nancumsum nanstd cbrt array_repr isscalar vander ravel_multi_index"
)
LINALG = words("cholesky cond det eig eigh eigvals eigvalsh inv lstsq matrix_power matrix_rank norm pinv qr solve svd")
NUMPY_TYPES = words("bool_ float16 float32 float64 int8 int16 int32 int64 uint8 uint16 uint32 uint64 intp")
PRODUCTS = ("convolve", "einsum", "ix_", "kron", "meshgrid", "outer", "tensordot")
CREATORS = words(
    "bincount diag diag_indices empty_like fromfunction full_like histogram ones_like tril_indices triu_indices vander "
    "zeros_like arange broadcast_to empty eye full geomspace identity indices linspace logspace ones pad repeat resize "
    "tile tri zeros"
)

# What the evaluator does with functions by their names.


STRUCTURAL = tuple(
    f"np.{name}"
    for name in words(
        "append array asarray atleast_1d atleast_2d broadcast_to column_stack concatenate copy diag dot dstack "
        "expand_dims flip fliplr flipud hstack insert matmul moveaxis outer ravel repeat reshape roll rot90 shape "
        "size split squeeze stack sum swapaxes tile transpose vstack cumsum cross trace array_split add subtract "
        "multiply divide"
    )
)
SCALARS = ("np.linalg.norm", "np.dot", "np.sum", "np.hypot", "np.arctan2", "np.mean", "np.max", "np.min")
KEPT = words(
    "np.sin np.cos np.tan np.arctan2 np.sqrt np.radians np.deg2rad np.abs np.floor np.ceil np.exp np.array np.dot "
    "np.hypot np.arctan np.arcsin np.arccos np.degrees np.rad2deg np.minimum np.maximum np.log np.sign np.pi"
)  # functions that the program keeps
COMPUTED = words(
    "len str repr ord chr bin hex oct divmod bool get index count startswith endswith upper lower title bit_length "
    "find split strip replace isupper islower isdigit isalpha format"
)  # functions without effects, computed for all turns of a loop
DEEP = words("str repr ascii hash print format json.dumps copy.deepcopy dataclasses.asdict dataclasses.astuple")
WHOLE = words("int ceil floor trunc comb factorial gcd isqrt lcm perm prod isclose isfinite isinf isnan")


# Operators.


BINARY: dict[type[ast.operator], tuple[Callable[[Any, Any], Any], Callable[[Any, Any], Any]]] = {
    ast.Add: (operator.add, operator.iadd), ast.Sub: (operator.sub, operator.isub),
    ast.Mult: (operator.mul, operator.imul), ast.Div: (operator.truediv, operator.itruediv),
    ast.FloorDiv: (operator.floordiv, operator.ifloordiv), ast.Mod: (operator.mod, operator.imod),
    ast.Pow: (operator.pow, operator.ipow), ast.MatMult: (operator.matmul, operator.imatmul),
    ast.BitAnd: (operator.and_, operator.iand), ast.BitOr: (operator.or_, operator.ior),
    ast.BitXor: (operator.xor, operator.ixor), ast.LShift: (operator.lshift, operator.ilshift),
    ast.RShift: (operator.rshift, operator.irshift),
}  # fmt: skip
UNARY: dict[type[ast.unaryop], Callable[[Any], Any]] = {
    ast.USub: operator.neg, ast.UAdd: operator.pos, ast.Invert: operator.invert, ast.Not: operator.not_,
}  # fmt: skip
COMPARISONS: dict[type[ast.cmpop], Callable[[Any, Any], Any]] = {
    ast.Eq: operator.eq, ast.NotEq: operator.ne, ast.Lt: operator.lt, ast.LtE: operator.le, ast.Gt: operator.gt,
    ast.GtE: operator.ge, ast.Is: lambda a, b: a is b, ast.IsNot: lambda a, b: a is not b,
    ast.In: lambda a, b: a in b, ast.NotIn: lambda a, b: a not in b,
}  # fmt: skip


# Large values are refused before they exist.


def weigh(value: Any) -> None:
    """Raise UnsupportedPython for a container whose text or comparison would be very long, or that is very deep."""
    if type(value) not in (tuple, list, dict) or not any(
        type(each) in (tuple, list, dict) for each in _parts_of(value)
    ):
        return
    weights: dict[int, int] = {}
    pending: list[tuple[Any, bool]] = [(value, False)]
    depth = 0
    while pending:
        each, is_done = pending.pop()
        parts = [part for part in _parts_of(each) if type(part) in (tuple, list, dict)]
        depth += -1 if is_done else 1
        if is_done or not parts:
            depth -= not is_done
            weights[id(each)] = len(each) + 1 + sum(weights.get(id(part), 1) for part in parts)
            if weights[id(each)] > MAX_ITEMS or depth > _MAX_NESTING:
                raise UnsupportedPython("this value contains too many others, or is nested too deeply")
        elif id(each) not in weights:
            weights[id(each)] = 1  # until its parts are known
            pending.append((each, True))
            pending += [(part, False) for part in parts if id(part) not in weights]
        else:
            depth -= 1


_MAX_NESTING = 2_000  # values within a value


def _parts_of(value: Any) -> Iterable[Any]:
    return value.values() if type(value) is dict else value


def check_widths(specification: str) -> None:
    """Raise UnsupportedPython for a specification of a format with a width that is too large."""
    if any(len(digits) > 4 for digits in "".join(c if c.isdigit() else " " for c in specification).split()):
        raise UnsupportedPython("this width of a text is too large")


def enlarged(value: Any, method: Callable[..., Any], *arguments: Any, **named: Any) -> Any:
    """Call a method whose result may be as many times larger as an argument is large."""
    items = [
        item for each in (*arguments, *named.values()) for item in (each.values() if type(each) is dict else [each])
    ]
    size = value.size if isinstance(value, np.ndarray) else len(getattr(value, "template", value))
    if size * max([1, *map(_times, items)]) > MAX_ITEMS:
        raise UnsupportedPython(f"this value has more than {MAX_ITEMS:,} items")
    return method(*arguments, **named)


def _times(value: Any) -> int:
    if isinstance(value, (str, bytes)):
        return len(value)
    return int(np.max(value, initial=1)) if isinstance(value, (int, list, np.ndarray)) else 1


_REPEATED = re.compile(r"(\\.|\[\^?\]?[^\]]*\]|\)|.)(?:[*+]|\{\d*,\d*\})")


def check_repetitions(pattern: str, length: int) -> None:
    """Raise UnsupportedPython for a pattern whose repetitions may be tried in too many combinations."""
    counts = Counter(_REPEATED.findall(pattern))
    broad = sum(n for atom, n in counts.items() if atom in (".", ")", "\\S", "\\W", "\\D") or atom.startswith("[^"))
    most = max((n for atom, n in counts.items()), default=0)
    if length ** max(broad, most) > 10**9 and length > 20:
        raise UnsupportedPython("this pattern may take too long to match", "use a simpler pattern, or a shorter text")


def repeats_choices(pattern: str) -> bool:
    """Return whether a pattern repeats a part that has alternatives or repetitions, so that it may backtrack without
    end."""
    try:
        return _has_choices(PARSER.parse(pattern), is_repeated=False)
    except re.error:
        return False  # which the search tells


def _has_choices(part: Any, *, is_repeated: bool) -> bool:
    for operation, value in part if isinstance(part, PARSER.SubPattern) else ():
        name = str(operation)
        is_repetition = name in ("MAX_REPEAT", "MIN_REPEAT") and value[0] != value[1]
        if is_repeated and (is_repetition or name == "BRANCH"):
            return True
        is_inside = is_repeated or (name in ("MAX_REPEAT", "MIN_REPEAT") and value[1] > 1)
        inner = value[1] if name == "BRANCH" else value if isinstance(value, tuple) else (value,)
        if any(_has_choices(each, is_repeated=is_inside) for each in inner):
            return True
    return False


_INSTEAD = {
    "np.fft": "add the waves with `np.sin` and `np.cos`", "globals": "put the functions into a dictionary by name",
    "locals": "put the values into a dictionary by name", "pathlib": "write the data into the program",
    "Path": "write the data into the program", "open": "write the data into the program",
    "pandas": "use lists and dictionaries",
    "scipy": "use numpy, or write the solver with a loop",
    "secrets": "use `random`", "uuid": "use `random`", "asyncio": "build the scene in one go, without tasks",
    "threading": "build the scene in one go, without threads", "sys": "leave this out", "os": "leave this out",
    "inspect": "name the functions in a list or dictionary", "argparse": "use constants at the top of the program",
    "trimesh": "build the scene from primitives", "matplotlib": "write colors as tuples of three numbers",
}  # fmt: skip


UNSAFE = ("os", "sys", "subprocess", "socket", "pickle", "shutil", "pathlib", "io", "importlib", "ctypes", "inspect")


def instead_of(path: str) -> str | None:
    """Return what to write instead of a name of a library."""
    return _INSTEAD.get(path) or _INSTEAD.get(path.partition(".")[0])


def few(function: Callable[..., Any]) -> Callable[..., Any]:
    def call(*arguments: Any, **named: Any) -> Any:
        if any(isinstance(each, int) and each > 100 for each in (*arguments, *named.values())):
            raise UnsupportedPython("this makes too many iterators")
        return function(*arguments, **named)

    return call


_MAX_PRODUCTS = 100_000_000  # that one call of einsum adds up


def _einsum_size(arguments: tuple[Any, ...]) -> float:
    """Return the size of the result of ``einsum`` with subscripts as a text; others are products of all sizes."""
    arrays = [np.asarray(each) for each in arguments if isinstance(each, (np.ndarray, list, tuple))]
    if not isinstance(arguments[0], str) or "." in arguments[0]:
        return float(np.prod([float(each.size) for each in arrays]))
    inputs, arrow, output = arguments[0].replace(" ", "").partition("->")
    letters = {c: n for text, each in zip(inputs.split(","), arrays) for c, n in zip(text, each.shape)}
    if float(np.prod([float(n) for n in letters.values()])) > _MAX_PRODUCTS:
        raise UnsupportedPython("this sum of products is too long")
    kept = output if arrow else "".join(c for c in letters if inputs.count(c) == 1)
    return float(np.prod([float(letters.get(c, 1)) for c in kept]))


def _implied_size(name: str, value: Any, named: Mapping[str, Any]) -> float:
    """Return the size of an array that follows from the shape or the values of another."""
    if name == "diag":
        return float(np.size(value)) ** 2 if np.ndim(value) == 1 else 1.0
    if name in _SQUARES:
        numbers = [each for each in (value, named.get("N"), named.get("M")) if isinstance(each, int)]
        return float(max(map(abs, numbers), default=1)) ** 2
    if name == "bincount":
        return float(max(np.max(value, initial=0), named.get("minlength", 0)))
    return float(np.prod(named["shape"])) if "shape" in named else 1.0


_SQUARES = ("eye", "identity", "tri", "tril_indices", "triu_indices")


def check_size(name: str, arguments: tuple[Any, ...], named: Mapping[str, Any]) -> None:
    """Raise an error for arguments that make a large array; they are checked before it exists."""
    if name in ("zeros_like", "ones_like", "empty_like", "full_like", "diag", "bincount", *_SQUARES):
        size = _implied_size(name, arguments[0], named)
    elif name in ("linspace", "logspace", "geomspace"):
        size = float(named.get("num", arguments[2] if len(arguments) > 2 else 50))
    elif name == "einsum":
        size = _einsum_size(arguments)
    elif name == "arange":
        start, stop, step = (0, *arguments, 1) if len(arguments) == 1 else (*arguments, 1)[:3]
        size = abs((stop - start) / (step or 1))
    else:
        size = 1.0
        for value in (*arguments, *named.values()):
            if name in PRODUCTS:
                size *= max(np.size(value), 1) if isinstance(value, (tuple, list, np.ndarray)) else 1
            elif isinstance(value, np.ndarray):
                size *= max(value.size, 1)
            else:
                numbers = value if isinstance(value, (tuple, list)) else [value] if name != "full" else []
                for each in numbers:
                    size *= max(abs(each), 1) if isinstance(each, (int, float)) else 1
    if size > MAX_ITEMS:
        raise UnsupportedPython(f"this array has more than {MAX_ITEMS:,} items")


def outer_product(function: np.ufunc) -> Callable[..., Any]:
    """Return the outer product of a function of numpy, of limited size."""

    def outer(left: Any, right: Any) -> Any:
        if np.size(left) * np.size(right) > MAX_ITEMS:
            raise UnsupportedPython(f"this array has more than {MAX_ITEMS:,} items")
        return function.outer(left, right)

    return outer


def product_of(items: Iterable[Any], *, start: Any = 1) -> Any:
    """Return the product of numbers, of limited size."""
    for item in items:
        start = start * item
        if type(start) is int and start.bit_length() > MAX_BITS:
            raise UnsupportedPython("this number has too many digits")
    return start
