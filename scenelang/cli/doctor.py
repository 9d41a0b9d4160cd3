"""The command doctor: what is installed, what works, what is missing."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterable, Iterator
from typing import TYPE_CHECKING, Any

from scenelang.cli.options import add_output
from scenelang.cli.output import print_json, use_color

if TYPE_CHECKING:
    from scenelang.doctor import Check

_TITLES = {
    "system": "System",
    "works": "What works",
    "packages": "Packages",
    "extras": "Extras",
    "services": "Services",
    "folders": "Folders",
    "terminal": "Terminal and browser",
}
_MARKS = {"ok": "ok", "note": "--", "missing": "no", "broken": "BROKEN"}
_COLORS = {"ok": "32", "note": "0", "missing": "33", "broken": "1;31"}


def add_doctor(subparsers: Any) -> None:
    parser = subparsers.add_parser(
        "doctor",
        help="what is installed, which backends work and what is missing",
        description="Try all that scenelang can do, each for a moment, and say what is missing and how to get it. "
        "The exit code is 1 only where something that needs no extra is broken.",
    )
    add_output(parser)
    parser.set_defaults(evaluates=False, run=doctor)


def doctor(arguments: argparse.Namespace) -> int:
    found = list(checks())
    if arguments.json:
        print_json([_facts(check) for check in found])
    else:
        print("\n".join(_lines(found, use_color(arguments, sys.stdout))))
    return 1 if any(check.state.value == "broken" for check in found) else 0


def checks() -> Iterator[Check]:
    """All findings; a group that fails to be looked at is a finding itself."""
    from scenelang.doctor import (
        Check,
        State,
        folder_checks,
        limit_checks,
        package_checks,
        service_checks,
        system_checks,
        terminal_checks,
        work_checks,
    )

    groups: tuple[tuple[str, Callable[[], Iterable[Check]]], ...] = (
        ("system", system_checks),
        ("limits", limit_checks),
        ("works", work_checks),
        ("packages", package_checks),
        ("services", service_checks),
        ("folders", folder_checks),
        ("terminal", terminal_checks),
    )
    for topic, group in groups:
        try:
            yield from group()
        except Exception as error:  # whatever is wrong with the installation, the others are told
            yield Check(topic, topic, State.BROKEN, f"{type(error).__name__}: {error}")


def _lines(found: list[Check], color: bool) -> Iterator[str]:
    width = max(len(check.name) for check in found)
    for topic, title in _TITLES.items():
        mine = [check for check in found if check.topic == topic]
        if mine:
            yield title
            yield from (_line(check, width, color) for check in mine)
    broken = sum(check.state.value == "broken" for check in found)
    remedies = list(dict.fromkeys(check.remedy for check in found if check.remedy.startswith(("pip ", "pipx "))))
    yield ""
    yield f"{broken} broken." if broken else "Everything that needs no extra works."
    if remedies:
        yield "To add what is missing:"
        yield from (f"  {remedy}" for remedy in remedies)


def _line(check: Check, width: int, color: bool) -> str:
    mark = _MARKS[check.state.value]
    if color:
        mark = f"\x1b[{_COLORS[check.state.value]}m{mark}\x1b[0m"
    remedy = f"; {check.remedy}" if check.remedy else ""
    return f"  {mark} {' ' * max(0, 2 - len(_MARKS[check.state.value]))}{check.name:<{width}}  {check.detail}{remedy}"


def _facts(check: Check) -> dict[str, str]:
    return {
        "topic": check.topic,
        "name": check.name,
        "state": check.state.value,
        "detail": check.detail,
        "remedy": check.remedy,
    }


COMMANDS = (add_doctor,)
