"""The definitions of a session as a program that loads again."""

from __future__ import annotations

import re
from collections.abc import Sequence

from scenelang.formatting import formatted
from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.source import Source, comment_above
from scenelang.interpreter.interactive import TopLevel
from scenelang.interpreter.replacing import is_assignment, names_of
from scenelang.interpreter.top_forms import TopForm
from scenelang.session import Session


def program_text(top: TopLevel) -> str:
    """The forms that made what there is now, with the comments above them, formatted; empty when there are none."""
    seen: set[str] = set()
    texts = []
    for form in top.lasting_forms():
        texts.append(_with_comment(form, seen))
        seen |= names_of(form)
    text = "\n\n".join(texts)
    return formatted(text + "\n") if text else ""


def checked_program(session: Session, top: TopLevel, name: str) -> str:
    """``program_text``, proven to load again. Raises SceneError when there is nothing to save, or when it would not:
    a definition needs an older version of another."""
    text = program_text(top)
    if not text:
        raise SceneError("value", "nothing has been defined, so there is nothing to save")
    errors = [d for d in session.check(Source(name, text)).diagnostics if d.is_error]
    if errors:
        hint = "give again, in order, the definitions that depend on one another"
        raise SceneError(errors[0].name, f"the definitions do not load in this order: {errors[0].message}", hint)
    return text


def comment_of(form: TopForm) -> list[str]:
    """The lines of comment directly above a form, as they are written."""
    span = form.datums[0].span
    return comment_above(span.source, span.start)


def _with_comment(form: TopForm, seen: set[str]) -> str:
    """A form with its comment; a value that is defined again becomes an assignment."""
    texts: Sequence[str] = [datum.span.text for datum in form.datums]
    if is_assignment(form) and names_of(form) <= seen:
        texts = [re.sub(r"define", "set!", texts[0], count=1)]
    return "\n".join([*comment_of(form), *texts])
