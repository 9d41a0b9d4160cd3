"""The GBNF form in xgrammar, which needs torch: `make test-grammar` has an environment of its own for it."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from scenelang.stdlib.reference import grammar_text

from .cases import GOOD, NOT_STRICT, OTHERS, ROOT, STRICT, UNSEEN, WRONG
from .test_formats import RIGHT_TEXTS, WRONG_TEXTS

xgrammar = pytest.importorskip("xgrammar")
END = 256


def _acceptor(strict: bool) -> Callable[[bytes], bool]:
    vocabulary = [*(bytes([value]) for value in range(256)), b"<end>"]
    kind = xgrammar.VocabType.RAW
    compiler = xgrammar.GrammarCompiler(xgrammar.TokenizerInfo(vocabulary, vocab_type=kind, stop_token_ids=[END]))
    compiled = compiler.compile_grammar(xgrammar.Grammar.from_ebnf(grammar_text("gbnf", strict)))

    def accepts(program: bytes) -> bool:
        run = xgrammar.GrammarMatcher(compiled)
        return all(run.accept_token(byte) for byte in program) and run.accept_token(END)

    return accepts


@pytest.fixture(scope="module")
def accepts() -> Callable[[bytes], bool]:
    return _acceptor(strict=False)


def test_every_example_is_accepted(accepts: Callable[[bytes], bool]) -> None:
    assert not [path for path in (*GOOD, *OTHERS) if not accepts(path.read_bytes())]


def test_every_mistake_of_shape_is_rejected(accepts: Callable[[bytes], bool]) -> None:
    assert not [path for path in WRONG if accepts(path.read_bytes())]
    assert all(accepts((ROOT / "tests" / "bad" / name).read_bytes()) for name in UNSEEN)


def test_texts(accepts: Callable[[bytes], bool]) -> None:
    assert not [case for case, text in RIGHT_TEXTS.items() if not accepts(text.encode())]
    assert not [case for case, text in WRONG_TEXTS.items() if accepts(text.encode())]


def test_the_strict_grammar_is_the_papers() -> None:
    strict = _acceptor(strict=True)
    assert strict(STRICT.read_bytes())
    others = [path for path in GOOD if path != STRICT]
    assert not [path for path in (*NOT_STRICT, *WRONG, *others) if strict(path.read_bytes())]
