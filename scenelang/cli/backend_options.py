"""Flags that come from what backends declare: added when a command that runs backends is parsed, and not before, since
that loads them."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import Any

from scenelang.backends.base import Option, Work, every

_WAITING = "arguments_that_wait"


def add_later(parser: argparse.ArgumentParser, add: Callable[[argparse.ArgumentParser], None]) -> None:
    """Let ``add`` give ``parser`` its further arguments just before it parses."""
    parse = parser.parse_known_args
    waiting = [add]

    def add_all() -> None:
        while waiting:
            waiting.pop()(parser)

    def parse_all(*arguments: Any, **named: Any) -> Any:
        add_all()
        return parse(*arguments, **named)

    parser.parse_known_args = parse_all  # type: ignore[method-assign]
    vars(parser)[_WAITING] = add_all


def add_now(parser: argparse.ArgumentParser) -> None:
    """Give ``parser`` the arguments that ``add_later`` holds back, for help and completion that parse nothing."""
    vars(parser).get(_WAITING, lambda: None)()


def add_backend_options(parser: argparse.ArgumentParser, work: Work) -> None:
    """A flag for every option of the backends that do ``work``; ``settings_of`` reads them back."""
    owners: dict[str, list[str]] = {}
    options: dict[str, Option] = {}
    for backend in every(work):
        for option in backend.options:
            owners.setdefault(option.name, []).append(backend.name)
            options.setdefault(option.name, option)
    group = parser.add_argument_group("options of backends")
    for name, option in options.items():
        text = f"{option.doc} ({', '.join(owners[name])}{_default(option)})".replace("%", "%%")
        if type(option.default) is bool:
            group.add_argument(f"--{name}", action="store_const", const=True, dest=_dest(name), help=text)
            continue
        kind = int if option.default is None else type(option.default)
        metavar = "|".join(option.choices) or {int: "N", float: "X"}.get(kind, "TEXT")
        group.add_argument(f"--{name}", type=kind, dest=_dest(name), metavar=metavar, help=text)
    parser.set_defaults(backend_options=tuple(options))


def settings_of(arguments: argparse.Namespace) -> dict[str, Any]:
    """The options of backends that were given, by name."""
    values = {name: getattr(arguments, _dest(name)) for name in arguments.backend_options}
    return {name: value for name, value in values.items() if value is not None}


def _dest(name: str) -> str:
    return f"backend_{name.replace('-', '_')}"


def _default(option: Option) -> str:
    return "" if option.default in (None, "") or type(option.default) is bool else f"; default {option.default}"
