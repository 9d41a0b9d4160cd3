"""The command grammar: the language's grammar for decoders of language models, parser generators, editors, people."""

from __future__ import annotations

import argparse
import sys
from typing import Any

from scenelang.cli.options import add_output, usage_errors
from scenelang.stdlib.grammars import GRAMMARS, grammar_text


def add_grammar(subparsers: Any) -> None:
    parser = subparsers.add_parser(
        "grammar",
        help="write the language's grammar for another program",
        description="Write the grammar of programs: text that reads and whose special forms have the right shape. "
        "Given to a decoder, it makes a local model write nothing else (docs/grammar.md).",
    )
    parser.add_argument("--format", required=True, choices=GRAMMARS, help="who is to read it")
    parser.add_argument("--strict", action="store_true", help="exactly the paper's grammar, as check --strict has it")
    parser.add_argument("-o", "--output", metavar="FILE", help="where to write it (default: standard output)")
    add_output(parser)
    parser.set_defaults(evaluates=False, run=grammar)


def grammar(arguments: argparse.Namespace) -> int:
    with usage_errors():
        text = grammar_text(arguments.format, arguments.strict)
    if arguments.output is None:
        sys.stdout.write(text)
        return 0
    from scenelang.backends.files import written_whole

    with written_whole(arguments.output) as path:
        path.write_text(text, encoding="utf-8")
    return 0


COMMANDS = (add_grammar,)
