"""The command grammar: the language's grammar for decoders of language models, parser generators, editors, people."""

from __future__ import annotations

import argparse
import sys
from typing import Any

from scenelang.cli.options import UsageError, add_output

PARSED = ("lark", "llguidance", "gbnf", "ebnf")  # the formats that say which programs there are
TEXTMATE = "textmate"


def add_grammar(subparsers: Any) -> None:
    parser = subparsers.add_parser(
        "grammar",
        help="write the language's grammar for another program",
        description="Write the grammar of programs: text that reads and whose special forms have the right shape. "
        "Given to a decoder, it makes a local model write nothing else (docs/grammar.md).",
    )
    parser.add_argument("--format", required=True, choices=(*PARSED, TEXTMATE), help="who is to read it")
    parser.add_argument("--strict", action="store_true", help="exactly the paper's grammar, as check --strict has it")
    parser.add_argument("-o", "--output", metavar="FILE", help="where to write it (default: standard output)")
    add_output(parser)
    parser.set_defaults(evaluates=False, run=grammar)


def grammar(arguments: argparse.Namespace) -> int:
    text = grammar_text(arguments.format, arguments.strict)
    if arguments.output is None:
        sys.stdout.write(text)
        return 0
    from scenelang.backends.files import written_whole

    with written_whole(arguments.output) as path:
        path.write_text(text, encoding="utf-8")
    return 0


def grammar_text(form: str, strict: bool = False) -> str:
    """The grammar in one of the formats. Raises UsageError for the strict form of one that has none."""
    from scenelang.grammar.export.textmate import textmate_text

    if form != TEXTMATE:
        return _parsed(form, strict)
    if strict:
        raise UsageError("value", "a TextMate grammar colours tokens, so it has no strict form")
    return textmate_text(_scopes())


def _parsed(form: str, strict: bool) -> str:
    from scenelang.grammar.export.ebnf import ebnf_text
    from scenelang.grammar.export.gbnf import gbnf_text
    from scenelang.grammar.export.lark_text import lark_text
    from scenelang.grammar.export.llguidance import llguidance_text
    from scenelang.interpreter.expand.forms import full_grammar, strict_grammar

    writers = {"lark": lark_text, "llguidance": llguidance_text, "gbnf": gbnf_text, "ebnf": ebnf_text}
    return writers[form](strict_grammar() if strict else full_grammar())


def _scopes() -> dict[str, frozenset[str]]:
    """The names of the language by the scope that editors give them."""
    from scenelang.stdlib.reference import vocabulary

    names = vocabulary()
    return {
        "keyword.control": names.forms,
        "storage.type": names.definitions,
        "keyword.other.paper": names.paper,
        "support.function": names.functions,
        "support.constant": names.constants,
    }


COMMANDS = (add_grammar,)
