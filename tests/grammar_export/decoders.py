"""The exported grammars in the programs that they are made for: each says whether it accepts a text."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache

import llguidance
from lark import Lark
from lark.exceptions import LarkError
from llguidance.gbnf_to_lark import gbnf_to_lark

from scenelang.stdlib.reference import grammar_text

Accepts = Callable[[bytes], bool]
FORMATS = ("lark", "llguidance", "gbnf")
END = 256


class _Bytes:
    """A tokenizer with one token for each byte, which makes the smallest steps that a decoder can make."""

    eos_token_id = END
    bos_token_id = None
    tokens: Sequence[bytes] = (*(bytes([value]) for value in range(256)), b"<end>")
    special_token_ids = (END,)

    def __call__(self, text: bytes) -> list[int]:
        return list(text)


@cache
def byte_tokenizer() -> llguidance.LLTokenizer:
    return llguidance.LLTokenizer(llguidance.TokenizerWrapper(_Bytes()))


def matcher(text: str) -> llguidance.LLMatcher:
    """A matcher at the beginning of a text of the grammar."""
    made = llguidance.LLMatcher(byte_tokenizer(), text)
    assert not made.is_error(), made.get_error()
    return made


def _llguidance(text: str) -> Accepts:
    start = matcher(text)

    def accepts(program: bytes) -> bool:
        run = start.deep_copy()
        return run.try_consume_tokens(list(program)) == len(program) and run.is_accepting()

    return accepts


def _lark(text: str) -> Accepts:
    parser = Lark(text, parser="lalr")

    def accepts(program: bytes) -> bool:
        try:
            parser.parse(program.decode("utf-8"))
            return True
        except (LarkError, UnicodeDecodeError):
            return False

    return accepts


@cache
def acceptor(form: str, strict: bool = False) -> Accepts:
    """Whether the grammar in a format accepts a program, by the program that reads that format."""
    text = grammar_text(form, strict)
    if form == "lark":
        return _lark(text)
    return _llguidance(gbnf_to_lark(text) if form == "gbnf" else text)
