"""Modules of Python's library that evaluated programs may import, of which no method of the evaluator is needed.

Values of their types have the attributes of the table ``METHODS``. What depends on the moment of the evaluation is
refused, or tainted as ``Elapsed``; messages to people (``logging``, ``warnings``, progress bars) have no effect.
"""

from __future__ import annotations

import base64
import calendar
import csv
import datetime
import decimal
import io
import struct
import sys
from typing import Any

from scenelang.interpreter.transpile.evaluation import MAX_ITEMS, METHODS, UnsupportedPython, words
from scenelang.interpreter.transpile.evaluation.objects import Native

_MOST_DIGITS = 2_000  # of a decimal number: `int` of one takes quadratic time

TYPES: dict[type, str] = {
    datetime.date: "day ctime isocalendar isoformat isoweekday month replace strftime timetuple toordinal weekday year",
    datetime.time: "hour isoformat microsecond minute replace second strftime",
    datetime.datetime: "date hour microsecond minute second time timestamp",  # besides those of a date
    datetime.timedelta: "days microseconds seconds total_seconds",
    decimal.Decimal: "adjusted as_tuple copy_abs is_signed normalize quantize sqrt to_integral_value",
    io.StringIO: "close getvalue read readline readlines seek write",
    csv.DictReader: "fieldnames line_num",
}
METHODS |= {kind: METHODS.get(kind, frozenset()) | frozenset(names.split()) for kind, names in TYPES.items()}


class Elapsed(float):
    """Seconds that a clock has measured: always 0, and nothing of a scene may depend on them."""

    def __new__(cls, value: float = 0.0) -> Elapsed:
        return super().__new__(cls, 0.0)


def _refusal(*_: Any) -> Any:
    raise UnsupportedPython("the scene depends on the time that this takes", "leave the clock out of what is built")


for _name in ("add", "radd", "sub", "rsub", "mul", "rmul", "truediv", "neg", "pos", "abs"):
    setattr(Elapsed, f"__{_name}__", lambda self, *_: Elapsed())
for _name in ("lt", "le", "gt", "ge", "eq", "ne", "bool", "int", "round", "hash", "floordiv", "mod", "rtruediv"):
    setattr(Elapsed, f"__{_name}__", _refusal)


def silent_modules() -> dict[str, dict[str, Any]]:
    """Return modules whose functions tell people something, and change nothing."""
    nothing = lambda *_, **__: None
    levels = dict(zip(words("DEBUG INFO WARNING ERROR CRITICAL"), range(10, 60, 10)))
    methods = words("debug info warning warn error critical exception log setLevel addHandler")
    logger = Native("logging.Logger", nothing, attributes={name: Native(name, nothing) for name in methods})
    logger.attributes |= {"isEnabledFor": Native("isEnabledFor", lambda _: False), "level": 30, "name": "scene"}
    logging: dict[str, Any] = {
        name: Native(f"logging.{name}", nothing) for name in (*methods, "basicConfig", "disable")
    }
    logging |= {**levels, "getLogger": Native("logging.getLogger", lambda *_: logger)}
    for name in ("NullHandler", "StreamHandler", "Formatter"):
        logging[name] = Native(f"logging.{name}", lambda *_, **__: logger)
    told = {name: Native(name, nothing) for name in ("write", "flush")}
    names = words("warn simplefilter filterwarnings resetwarnings")
    bar = Native("tqdm.tqdm", lambda items=(), *_, **__: items)
    spans = Native("tqdm.trange", lambda *bounds, **_: range(*bounds))
    return {
        "logging": logging,
        "sys": {
            **{name: Native(f"sys.{name}", nothing, attributes=told) for name in ("stderr", "stdout")},
            "maxsize": sys.maxsize,
            "setrecursionlimit": Native("sys.setrecursionlimit", nothing),
        },
        "warnings": {name: Native(f"warnings.{name}", nothing) for name in names},
        "tqdm": {"tqdm": bar, "trange": spans},
        "tqdm.auto": {"tqdm": bar, "trange": spans},
        "time": {
            **{name: Native(f"time.{name}", Elapsed) for name in words("perf_counter monotonic process_time")},
            **{name: _refused("time", name) for name in words("time time_ns localtime gmtime strftime ctime")},
            "sleep": Native("time.sleep", nothing),
        },
    }


def _refused(module: str, name: str) -> Native:
    def refuse(*_: Any, **__: Any) -> Any:
        raise UnsupportedPython(
            f"`{module}.{name}` gives another value in every run", "write a fixed moment into the program"
        )

    return Native(f"{module}.{name}", refuse)


def plain_modules() -> dict[str, dict[str, Any]]:
    """Return modules of functions that compute with texts, bytes, dates and numbers."""
    encodings = words("b64encode b64decode b32encode b32decode b16encode b16decode urlsafe_b64encode urlsafe_b64decode")
    return {
        "base64": {name: Native(f"base64.{name}", getattr(base64, name)) for name in encodings},
        "csv": {
            "reader": Native("csv.reader", lambda lines, **options: csv.reader(lines, **options)),
            "DictReader": Native("csv.DictReader", lambda lines, *rest, **named: csv.DictReader(lines, *rest, **named)),
            "QUOTE_MINIMAL": csv.QUOTE_MINIMAL, "QUOTE_NONE": csv.QUOTE_NONE, "QUOTE_NONNUMERIC": csv.QUOTE_NONNUMERIC,
        },
        "calendar": {
            **{
                name: Native(f"calendar.{name}", getattr(calendar, name))
                for name in words("isleap monthcalendar monthrange weekday")
            },
            **{name: list(getattr(calendar, name)) for name in words("day_abbr day_name month_abbr month_name")},
        },
        "io": {"StringIO": Native("io.StringIO", io.StringIO, io.StringIO)},
        "datetime": _dates(),
        "decimal": _decimals(),
        "struct": {
            "pack": Native("struct.pack", _packed), "calcsize": Native("struct.calcsize", struct.calcsize),
            "unpack": Native("struct.unpack", lambda form, data: struct.unpack(_small(form), data)),
            "unpack_from": Native("struct.unpack_from", lambda form, *rest: struct.unpack_from(_small(form), *rest)),
            "iter_unpack": Native("struct.iter_unpack", lambda form, data: struct.iter_unpack(_small(form), data)),
        },
    }  # fmt: skip


def _small(form: str) -> str:
    if struct.calcsize(form) > MAX_ITEMS:
        raise UnsupportedPython("these bytes are too many")
    return form


def _packed(form: str, *values: Any) -> bytes:
    return struct.pack(_small(form), *values)


def _dates() -> dict[str, Any]:
    def kind(cls: Any, makers: str, moments: str = "") -> Native:
        own = {name: Native(f"datetime.{cls.__name__}.{name}", getattr(cls, name)) for name in words(makers)}
        own |= {name: _refused(f"datetime.{cls.__name__}", name) for name in words(moments)}
        own |= {name: getattr(cls, name) for name in ("min", "max")}
        return Native(f"datetime.{cls.__name__}", cls, cls, attributes=own)

    utc = datetime.UTC
    return {
        "date": kind(datetime.date, "fromisoformat fromordinal fromisocalendar", "today fromtimestamp"),
        "datetime": kind(
            datetime.datetime, "fromisoformat fromordinal strptime combine", "now today utcnow fromtimestamp"
        ),
        "time": kind(datetime.time, "fromisoformat"),
        "timedelta": kind(datetime.timedelta, ""),
        "timezone": Native("datetime.timezone", datetime.timezone, datetime.timezone, attributes={"utc": utc}),
        "UTC": utc,
    }


def _decimals() -> dict[str, Any]:
    def make(value: Any = "0") -> decimal.Decimal:
        return check_digits(decimal.Decimal(value))

    roundings = {name: getattr(decimal, name) for name in dir(decimal) if name.startswith("ROUND_")}
    context = Native("decimal.Context", lambda *_: None, attributes={"prec": decimal.getcontext().prec})
    return {
        "Decimal": Native("decimal.Decimal", make, decimal.Decimal),
        "getcontext": Native("decimal.getcontext", lambda: context),
        "InvalidOperation": Native("decimal.InvalidOperation", decimal.InvalidOperation, decimal.InvalidOperation),
        **roundings,
    }


def check_digits(value: decimal.Decimal) -> decimal.Decimal:
    """Return a decimal number that is neither very large nor very small."""
    if value.is_finite() and abs(value.adjusted()) + len(value.as_tuple().digits) > _MOST_DIGITS:
        raise UnsupportedPython("this number has too many digits")
    return value
