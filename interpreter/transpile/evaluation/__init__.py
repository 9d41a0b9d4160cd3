"""Evaluation of Python during the translation, by an interpreter of its syntax tree that never executes Python.

What the translation proper does not support is evaluated here (``folding``); the rest of the program stays as it is.
"""

from __future__ import annotations

import ast
from collections import ChainMap, Counter, OrderedDict, defaultdict, deque
from fractions import Fraction
from random import Random
from re import Match, Pattern
from string import Template

import numpy as np


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
    int: "bit_count bit_length conjugate denominator from_bytes imag numerator real to_bytes",
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
    Random: "betavariate choice choices expovariate gammavariate gauss getrandbits lognormvariate normalvariate "
    "paretovariate randint random randrange sample seed shuffle triangular uniform vonmisesvariate weibullvariate",
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
    "swapaxes take tolist trace transpose var",
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
PRODUCTS = ("einsum", "ix_", "kron", "meshgrid", "outer", "tensordot")
CREATORS = words(
    "arange broadcast_to empty eye full geomspace identity indices linspace logspace ones pad repeat resize tile tri "
    "zeros"
)
