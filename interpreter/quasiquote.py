"""Quasiquote: a template is lowered to ``cons`` and ``append``; constant parts stay constants.

Inside a ``define-macro`` body the symbols of a template become aliases, one set per expansion, so that they keep the
meaning that they have where the macro is defined (see ``scope.Alias``).
"""

from __future__ import annotations

from typing import Any

from scenelang.grammar.datum import ArrayDatum, Atom, Datum, ListDatum, Symbol
from scenelang.grammar.source import Span
from scenelang.interpreter.expand import Expander, core, is_identifier, opaque, syntax_error
from scenelang.interpreter.library import Builtin
from scenelang.interpreter.scope import Scope, base_name
from scenelang.interpreter.syntax_values import BRACKETS, quoted_value


def expand_template(expander: Expander, datum: Datum, scope: Scope) -> Datum:
    """The core datum that builds the value of a quasiquoted template."""
    return _Template(expander, scope).build(datum, 1)


class _Template:
    def __init__(self, expander: Expander, scope: Scope) -> None:
        self.expander = expander
        self.scope = scope

    def build(self, datum: Datum, level: int) -> Datum:
        if self._is_constant(datum):
            return core("QUOTE", [opaque("DATUM", quoted_value(datum), datum.span)], datum.span)
        if isinstance(datum, Atom):
            return self._alias(datum)
        if isinstance(datum, ArrayDatum):
            return self._array(datum, level)
        head = self._keyword(datum)
        if head == "unquote" and level == 1:
            return self.expander.expand(datum.items[1], self.scope)
        if head == "unquote-splicing" and level == 1:
            raise syntax_error("quasiquote", "`,@` splices into a list, and there is none around it", datum.span)
        if head is not None:
            level += 1 if head == "quasiquote" else -1
        return self._list(datum.items, datum.tail, datum.span, level)

    def _list(self, items: tuple[Datum, ...], tail: Datum | None, span: Span, level: int) -> Datum:
        dotted = len(items) > 2 and is_identifier(items[-2]) and base_name(items[-2].value) == "unquote"
        if tail is None and dotted:  # (a . ,b) reads as (a unquote b)
            result = self.build(ListDatum(items[-2:], None, span), level)
            items = items[:-2]
        else:
            empty = core("QUOTE", [opaque("DATUM", quoted_value(ListDatum((), None, span)), span)], span)
            result = self.build(tail, level) if tail is not None else empty
        for item in reversed(items):
            if isinstance(item, ListDatum) and self._keyword(item) == "unquote-splicing" and level == 1:
                result = self._call("append", span, self.expander.expand(item.items[1], self.scope), result)
            else:
                result = self._call("cons", span, self.build(item, level), result)
        return result

    def _array(self, datum: ArrayDatum, level: int) -> Datum:
        if self.expander.template_scope is not None:
            mark = core("QUOTE", [opaque("DATUM", BRACKETS, datum.span)], datum.span)
            return self._call("cons", datum.span, mark, self._list(datum.items, None, datum.span, level))
        splices = any(isinstance(i, ListDatum) and self._keyword(i) == "unquote-splicing" for i in datum.items)
        if splices:
            return self._call("array", datum.span, self._list(datum.items, None, datum.span, level))
        return ArrayDatum(tuple([self.build(item, level) for item in datum.items]), datum.span)

    def _call(self, name: str, span: Span, *operands: Datum) -> Datum:
        return ListDatum((self.expander.builtin(name, span, self.scope), *operands), None, span)

    def _alias(self, atom: Atom) -> Datum:
        """A symbol of a macro's template: looked up among the aliases of the running expansion."""
        symbol = atom.value

        def alias(rt: Any) -> Any:
            return self.expander.template_alias(symbol)

        maker = Builtin("template-symbol", "", "Symbol", alias, "A template's symbol.", None, "macros")
        return ListDatum((Atom(maker, atom.span),), None, atom.span)

    @staticmethod
    def _keyword(datum: ListDatum) -> str | None:
        """``unquote`` and so on, when the datum is such a form."""
        if len(datum.items) == 2 and datum.tail is None and is_identifier(datum.items[0]):
            name = base_name(datum.items[0].value)
            if name in ("unquote", "unquote-splicing", "quasiquote"):
                return name
        return None

    def _is_constant(self, datum: Datum) -> bool:
        """True when nothing is unquoted within (nor, in a macro's template, any symbol needs an alias)."""
        aliased = self.expander.template_scope is not None
        stack = [datum]
        while stack:
            item = stack.pop()
            if isinstance(item, Atom):
                if aliased and isinstance(item.value, Symbol):
                    return False
                continue
            if isinstance(item, ListDatum):
                if self._keyword(item) is not None or (
                    any(is_identifier(i) and base_name(i.value) == "unquote" for i in item.items)
                ):
                    return False
                if item.tail is not None:
                    stack.append(item.tail)
            elif aliased:
                return False
            stack.extend(item.items)
        return True
