"""The command explain: why an error or warning arises and how it is mended."""

from __future__ import annotations

import argparse
from typing import Any

from scenelang.cli.options import UsageError, add_output
from scenelang.cli.output import print_json
from scenelang.grammar.diagnostics import CODES, MENDS, diagnostic_named, explanation, suggest


def add_explain(subparsers: Any) -> None:
    parser = subparsers.add_parser(
        "explain",
        help="why an error or warning arises, and how to mend it",
        description="Explain codes such as E301, or names such as unbound; without any, list them all.",
    )
    parser.add_argument("codes", metavar="CODE", nargs="*", help="codes or names of errors and warnings")
    add_output(parser)
    parser.set_defaults(evaluates=False, run=explain)


def explain(arguments: argparse.Namespace) -> int:
    names = [name_of(asked) for asked in arguments.codes]
    if arguments.json:
        print_json([_facts(name, MENDS[name]) for name in names or _in_order()])
    elif names:
        print("\n\n".join("\n".join(explanation(name)) for name in names))
    else:
        print("\n".join(f"{CODES[name].code} {name}: {CODES[name].why}" for name in _in_order()))
    return 0


def name_of(asked: str) -> str:
    """The name of the diagnostic that a code or name means; raises UsageError for one that there is not."""
    name = diagnostic_named(asked)
    if name is not None:
        return name
    hint = (
        suggest(asked, [*(entry.code for entry in CODES.values()), *CODES]) or "`scenelang explain` lists all of them"
    )
    raise UsageError("value", f"there is no code or name `{asked[:80]}`", hint)


def _in_order() -> list[str]:
    return sorted(CODES, key=lambda name: CODES[name].code)


def _facts(name: str, mend: str) -> dict[str, str]:
    return {"code": CODES[name].code, "name": name, "why": CODES[name].why, "mend": mend}


COMMANDS = (add_explain,)
