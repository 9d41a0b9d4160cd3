"""The shapes of the special forms as grammar: what may follow the head of each, and the parts that they share.

Notation: Lark's, over datums: `"("` is a bracket, capitals are tokens of ``grammar/export/tokens``. ``derived``,
``definitions``, ``macros`` and ``program`` check the same shapes with messages for people; tests compare the two.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from scenelang.interpreter.forms import FORMS

_LET = "bindings body"
_LOOP = "binder loop_bindings body"
_FOR = "clauses body"

# Forms that are expressions, by head.
EXPRESSIONS: Mapping[str, str] = MappingProxyType({
    "quote": "datum",
    "quasiquote": "template",
    "if": "expr expr expr?",
    "lambda": "parameters body",
    "let-syntax": "macro_bindings body",
    "letrec-syntax": "macro_bindings body",
    "bind": "expr expr",
    "set!": "name expr",
    "let": f"{_LET} | {_LOOP}",
    "let*": _LET,
    "letrec": _LET,
    "letrec*": _LET,
    "let-values": f"{_LET} | {_LOOP}",
    "let*-values": _LET,
    "begin0": "expr+",
    "cond": "cond_clauses",
    "case": "expr case_clauses",
    "when": "expr body",
    "unless": "expr body",
    "and": "expr*",
    "or": "expr*",
    "do": '"(" do_variable* ")" "(" expr body? ")" body?',
    "while": "expr body?",
    "let/ec": "binder body",
    "guard": '"(" binder cond_clauses? ")" body',
    "assert": "expr expr?",
    **{name: _FOR for name in FORMS if name.startswith("for") and not name.endswith("/fold")},
    **dict.fromkeys(("for/fold", "for*/fold"), f"accumulators {_FOR}"),
})  # fmt: skip

# Forms of bodies and of the top level that define names.
DEFINITIONS: Mapping[str, str] = MappingProxyType({
    "define": 'NAME expr | "(" NAME parameter_list? rest? ")" body',
    "define-values": "target expr",
    "define-record": "NAME field* default_field*",
})  # fmt: skip

# Those that define macros; a body of nothing else is empty.
MACROS: Mapping[str, str] = MappingProxyType({
    "define-syntax": "NAME rules",
    "define-macro": '"(" NAME parameter_list? rest? ")" body',
})  # fmt: skip

# Forms that stand at top level only.
TOP_LEVEL: Mapping[str, str] = MappingProxyType({
    "import": 'STRING (":prefix" SYMBOL)?',
    "scene": "expr+",
    "param": 'NAME expr STRING? (":min" NUMBER | ":max" NUMBER)*',
})  # fmt: skip

# Forms that the rules below spell out: where `begin` stands decides what it may hold, `syntax-rules` is no expression.
SPELLED_OUT = frozenset({"begin", "syntax-rules"})

RULES = """
start: top*
top: plain | "(" "begin" top* ")" | definition | macro_definition | top_form

expr: plain | begin
begin: "(" "begin" expr+ ")"
plain: name | literal | array | form | application | quotation
name: NAME | "@" | "scene" | "param"
binder: name | "_"
literal: NUMBER | STRING | BOOLEAN | NONE | KEYWORD | ANNOTATED_KEYWORD | HANDLE
array: "[" expr* "]"
application: "(" callee operand* ")"
callee: NAME | "@" | literal | array | form | begin | application | quotation
operand: expr | definition | "else" | "=>"

body: silent* loud (silent | loud)*
silent: macro_definition | "(" "begin" silent+ ")"
loud: plain | definition | "(" "begin" body ")"

parameters: bare_parameter | "(" ")" | "(" parameter_list rest? ")"
parameter_list: early+ | early* optional late*
early: bare_parameter | keyword_parameter
late: optional | keyword_parameter
bare_parameter: binder | ANNOTATED
optional: "(" bare_parameter expr ")"
keyword_parameter: bare_keyword | "(" bare_keyword expr ")" | "&keys" bare_parameter
bare_keyword: KEYWORD | ANNOTATED_KEYWORD
rest: "." bare_parameter

target: binder | "(" target* ")" | "(" target+ "." target ")"
bindings: "(" binding* ")"
binding: "(" target expr ")"
loop_bindings: "(" optional* ")"
accumulators: "(" accumulator* ")"
accumulator: "(" binder expr ")"
clauses: "(" clause* ")"
clause: binding | (":when" | ":unless" | ":break") expr
do_variable: "(" bare_parameter expr expr? ")"

cond_clauses: cond_clause+ else_clause? | else_clause
cond_clause: "(" expr ")" | "(" expr "=>" expr ")" | "(" expr body ")"
else_clause: "(" "else" body ")"
case_clauses: case_clause+ case_else? | case_else
case_clause: "(" "(" datum* ")" ("=>" expr | body) ")"
case_else: "(" "else" ("=>" expr | body) ")"

field: name | ANNOTATED
default_field: "(" field expr ")"

macro_bindings: "(" macro_binding* ")"
macro_binding: "(" NAME rules ")"
rules: "(" "syntax-rules" literals rule* ")" | "(" "syntax-rules" NAME literals free_rule* ")"
literals: "(" datum* ")"
rule: "(" pattern_list datum ")"
free_rule: "(" list datum ")"
pattern_list: "(" ")" | "(" pattern_items ("." PATTERN_SYMBOL)? ")"
pattern_items: pattern+ | pattern+ "..." pattern*
pattern: PATTERN_SYMBOL | ANNOTATED | literal | pattern_list | "[" pattern_items? "]" | "'" pattern

datum: SYMBOL | ANNOTATED | literal | list | "[" datum* "]"
     | "'" datum | "`" datum | "," datum | ",@" datum
list: "(" datum* ")" | "(" datum+ "." datum ")"

quotation: "'" datum | "`" template
template: TEMPLATE_SYMBOL | ANNOTATED | literal | "[" member* "]" | "'" template | "`" inner_template
        | "," unquoted | "(" "unquote" expr ")" | "(" "quasiquote" inner_template ")"
        | "(" member* ")" | "(" member+ "." template ")"
inner_template: TEMPLATE_SYMBOL | ANNOTATED | literal | "[" inner_template* "]" | "'" inner_template | "," template
      | ",@" template | "(" inner_template* ")" | "(" inner_template+ "." inner_template ")"
unquoted: NAME | "scene" | "param" | literal | array | form | begin | application | quotation
member: template | ",@" expr | "(" "unquote-splicing" expr ")"
"""
