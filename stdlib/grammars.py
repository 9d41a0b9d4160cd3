"""The language's grammar as text, for decoders of language models, parser generators, editors and people."""

from __future__ import annotations

from scenelang.grammar.diagnostics import SceneError

PARSED = ("lark", "llguidance", "gbnf", "ebnf")  # the formats that say which programs there are
TEXTMATE = "textmate"
GRAMMARS = (*PARSED, TEXTMATE)


def grammar_text(form: str, strict: bool = False) -> str:
    """The grammar of programs in a format; docs/grammar.md says what each is for.

    Parameters
    ----------
    form : str
        "lark", "llguidance", "gbnf", "ebnf" or "textmate".
    strict : bool
        The paper's grammar, as ``check --strict`` has it.

    Raises
    ------
    SceneError
        There is no such format, or it has no strict form.

    Examples
    --------
    >>> "start" in grammar_text("lark")
    True
    """
    from scenelang.grammar.export.textmate import textmate_text

    if form not in GRAMMARS:
        raise SceneError("value", f"unknown grammar format `{form}`; expected {', '.join(GRAMMARS)}")
    if form != TEXTMATE:
        return _parsed(form, strict)
    if strict:
        raise SceneError("value", "a TextMate grammar colours tokens, so it has no strict form")
    return textmate_text(_scopes())


def _parsed(form: str, strict: bool) -> str:
    from scenelang.grammar.export.ebnf import ebnf_text
    from scenelang.grammar.export.gbnf import gbnf_text
    from scenelang.grammar.export.lark_text import lark_text, llguidance_text
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
