"""Python expressions -> code of the language."""

from __future__ import annotations

import ast
import math
import re
from collections.abc import Sequence

from scenelang.grammar.datum import Span
from scenelang.grammar.diagnostics import SceneError, suggest
from scenelang.interpreter.transpile.analysis.inference import (
    ARRAY,
    CONTAINERS,
    DICT,
    POSE,
    RECORD,
    SEQUENCES,
    SHAPE,
    UNKNOWN,
)
from scenelang.interpreter.transpile.analysis.known import RESULTS
from scenelang.interpreter.transpile.analysis.scopes import (
    ANNOTATIONS,
    BUILTINS,
    FORBIDDEN,
    Comprehension,
    Function,
    PythonVariable,
    is_module,
)
from scenelang.interpreter.transpile.helper_api import HELPERS
from scenelang.interpreter.transpile.writing import operators
from scenelang.interpreter.transpile.writing.calls import CALLS, CONSTANTS, VALUES
from scenelang.interpreter.transpile.writing.code import (
    Brackets,
    Code,
    FormCode,
    Key,
    LiteralCode,
    Name,
    VariableRef,
    form,
    is_form,
    kebab,
    lambda_list,
    none,
    quote,
)
from scenelang.interpreter.transpile.writing.methods import call_method
from scenelang.interpreter.transpile.writing.user_calls import Records, call_function, wrapped
from scenelang.interpreter.transpile.writing.writer import Analysed, Flows

_METHODS_OF_ONE = ("get", "append", "add", "index", "count", "remove", "startswith", "endswith", "extend")
_PLAIN_NUMBER = re.compile(r"(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")


class ExpressionWriter(Flows):
    """Writes expressions; what cannot be translated becomes a diagnostic with its place in the Python."""

    def __init__(self, analysed: Analysed) -> None:
        super().__init__(analysed)
        self.records = Records()
        self.late: dict[PythonVariable, PythonVariable] = {}

    def expr(self, node: ast.expr) -> Code:
        """The code of any expression."""
        method = getattr(self, f"_{type(node).__name__}", None)
        if method is None:
            raise self.unsupported(f"`{type(node).__name__.lower()}`", node)
        try:
            code: Code = method(node)
        except SceneError as error:  # noted, so that the rest is looked at as well; nothing is written in the end
            self.diagnostics.append(error.diagnostic)
            return form("list")
        if code.span is None:
            code.span = self.span(node)
        is_made = isinstance(node, (ast.Call, ast.BinOp, ast.Subscript))
        if (
            is_made
            and self.type(node).only(ARRAY | POSE)
            and self.is_mutated(node)
            and not is_form(code, "mutable-array")
        ):
            return form("mutable-array", code, span=code.span)
        return code

    def field_name(self, name: str) -> Code:
        """The name of a record's field."""
        return Name(kebab(name))

    def field_key(self, name: str) -> Code:
        """``:field`` in a call of a record's constructor."""
        return Key(kebab(name))

    def is_python_stream(self, node: ast.expr) -> bool:
        """Whether a stream is one of Python's ``random``, not of numpy."""
        return "random.Random" in self.type(node).names

    # --- leaves ---

    def _Constant(self, node: ast.Constant) -> Code:
        value = node.value
        if isinstance(value, str) and any("\ud800" <= c <= "\udfff" for c in value):
            raise self.unsupported("a string with half a character", node)
        if value is None or isinstance(value, (bool, str)):
            return LiteralCode(value)
        if isinstance(value, (int, float)):
            text = self.text.text(node) if value != math.inf else "1e999"  # `inf` may be a variable of the program
            return LiteralCode(value, None, text if _PLAIN_NUMBER.fullmatch(text) else None)
        raise self.unsupported(f"the constant `{value!r}`", node)

    def _Name(self, node: ast.Name) -> Code:
        path = self.paths.of(node)
        if path is not None:
            return self._library_value(node, path)
        variable = self.names.variables[node]
        function = self.single_function(node)
        is_given_on = isinstance(self.parent(node), (ast.Call, ast.keyword, ast.Starred))
        if function is not None and is_given_on and any(p.variable.is_keyword for p in function.parameters):
            return wrapped(self, function, node)
        return VariableRef(variable, self.span(node))

    def _library_value(self, node: ast.expr, path: str) -> Code:
        """A constant or function of the library as a value."""
        if path in CONSTANTS:
            return Name(CONSTANTS[path])
        if path in VALUES:
            return VALUES[path](self)
        self.check_path(node, path)
        raise self.unsupported(f"`{self.text.text(node)}` as a value", node)

    def check_path(self, node: ast.expr, path: str) -> None:
        """Raise what is wrong with using the library name ``path``, if anything is."""
        top = path.split(".")[0]
        if top in FORBIDDEN or path in FORBIDDEN:
            raise self.error(
                "python-forbidden",
                f"`{self.text.text(node)}` has no meaning for a scene: it reaches {FORBIDDEN[top]}",
                node,
            )
        if path.rpartition(".")[2].startswith("__") or path.startswith("__"):
            raise self.error("python-forbidden", f"`{self.text.text(node)}` reaches Python's own insides", node)
        known = path in RESULTS or path in BUILTINS or path in HELPERS or is_module(path) or path in ANNOTATIONS
        if known:
            return
        if "." in path and is_module(path.rpartition(".")[0]):
            module, _, name = path.rpartition(".")
            near = [p.removeprefix(module + ".") for p in RESULTS if p.startswith(module + ".")]
            raise self.error(
                "python-unsupported", f"`{self.text.text(node)}` is not known here", node, suggest(name, near)
            )
        visible = {v.name for v in self.names.variables.values()} | set(HELPERS) | BUILTINS
        raise self.error("python-name", f"the name `{path}` is not defined", node, suggest(path, sorted(visible)))

    def _Attribute(self, node: ast.Attribute) -> Code:
        path = self.paths.of(node)
        if path is not None:
            return self._library_value(node, path)
        if node.attr.startswith("__"):
            raise self.error("python-forbidden", f"`.{node.attr}` reaches Python's own insides", node)
        owner = self.type(node.value)
        if owner.kinds & RECORD or owner.classes:
            return self.field(node)
        if owner.kinds & (ARRAY | POSE) or not owner.kinds:
            known = {"shape": "array-shape", "T": "transpose", "size": "length"}.get(node.attr)
            if known is not None:
                return form(known, self.expr(node.value))
        if node.attr in _METHODS_OF_ONE:
            return self._bound_method(node)
        raise self.unsupported(f"the attribute `.{node.attr}`", node)

    def _bound_method(self, node: ast.Attribute) -> Code:
        """``key=counts.get``: a function of one argument that calls the method."""
        variable = PythonVariable("key", None, is_temporary=True)
        argument = ast.copy_location(ast.Name("key", ast.Load()), node)
        self.names.variables[argument] = variable
        call = ast.copy_location(ast.Call(node, [argument], []), node)
        return form("lambda", FormCode([VariableRef(variable)]), call_method(self, call, node))

    def field(self, node: ast.Attribute) -> Code:
        """``record.field``."""
        from scenelang.interpreter.transpile.writing.user_calls import read_field

        return read_field(self, node)

    # --- displays ---

    def _Tuple(self, node: ast.Tuple) -> Code:
        return self._display(node, node.elts)

    def _List(self, node: ast.List) -> Code:
        return self._display(node, node.elts)

    def _display(self, node: ast.Tuple | ast.List, elements: list[ast.expr]) -> Code:
        is_mutable = self.is_mutated(node)
        if any(isinstance(e, ast.Starred) for e in elements):
            joined = self._joined(elements)
            return form("mutable", joined) if is_mutable else joined
        if is_mutable:
            return form("mutable-list", *self._items(elements))
        if self.wants_vector(node) and self.is_vector_literal(node):
            return Brackets(self._items(elements))
        return self._list(node, elements)

    def _list(self, node: ast.expr, elements: list[ast.expr]) -> Code:
        """An immutable list: quoted data where it is constant, a template where it mostly is."""
        if self._is_data(node):
            return quote(self._data(node, quasi=False))
        leaves = self._leaves(node)
        nested = any(isinstance(e, (ast.Tuple, ast.List)) for e in elements)
        constant = sum(1 for leaf in leaves if is_constant(leaf))
        if nested and leaves and 2 * constant >= len(leaves) and self._is_template(node):
            return form("quasiquote", self._data(node, quasi=True))
        return form("list", *self._items(elements))

    def _items(self, elements: Sequence[ast.expr]) -> list[Code]:
        return [self.comment_item(self.expr(element), element) for element in elements]

    def _joined(self, elements: list[ast.expr]) -> Code:
        """``[*a, b, *c]``."""
        pieces: list[Code] = []
        run: list[ast.expr] = []
        is_shape = False

        def close() -> None:
            if run:
                if all(is_constant(e) for e in run):
                    pieces.append(quote(FormCode([self._data(e, quasi=False) for e in run])))
                else:
                    pieces.append(form("list", *self._items(run)))
                run.clear()

        for element in elements:
            if isinstance(element, ast.Starred):
                close()
                is_shape |= bool(self.type(element.value).kinds & SHAPE)
                pieces.append(self.comment_item(self.iterable(element.value), element))
            else:
                run.append(element)
        close()
        if len(pieces) == 1 and not is_shape:
            return form("->list", pieces[0])
        return form("append", *pieces)

    def _leaves(self, node: ast.expr) -> list[ast.expr]:
        if isinstance(node, (ast.Tuple, ast.List)):
            return [leaf for element in node.elts for leaf in self._leaves(element)]
        return [node]

    def _is_data(self, node: ast.expr) -> bool:
        """Whether a display is all constants, and no part of it ever changes."""
        if isinstance(node, (ast.Tuple, ast.List)):
            return not self.is_mutated(node) and all(self._is_data(e) for e in node.elts)
        return is_constant(node)

    def _is_template(self, node: ast.expr) -> bool:
        if isinstance(node, (ast.Tuple, ast.List)):
            return not self.is_mutated(node) and all(
                not isinstance(e, ast.Starred) and self._is_template(e) for e in node.elts
            )
        return True

    def _data(self, node: ast.expr, quasi: bool) -> Code:
        if isinstance(node, (ast.Tuple, ast.List)):
            items = [self.comment_item(self._data(e, quasi), e) for e in node.elts]
            return FormCode(items, self.span(node))
        if is_constant(node) or not quasi:
            return self.expr(node)
        return form("unquote", self.expr(node), span=self.span(node))

    def _Set(self, node: ast.Set) -> Code:
        if any(isinstance(e, ast.Starred) for e in node.elts):
            return form("list->set", self._joined(node.elts))
        return form("set", *self._items(node.elts))

    def _Dict(self, node: ast.Dict) -> Code:
        pieces: list[Code] = []
        pairs: list[Code] = []
        for key, value in zip(node.keys, node.values):
            if key is None:
                if pairs:
                    pieces.append(form("table", *pairs))
                    pairs = []
                pieces.append(self.expr(value))
            else:
                pairs += [self.comment_item(self.expr(key), key), self.comment_item(self.expr(value), value)]
        if pairs or not pieces:
            pieces.append(form("table", *pairs))
        is_one = len(pieces) == 1 and (not node.keys or node.keys[0] is not None)
        return pieces[0] if is_one else form("table-merge", *pieces)

    # --- comprehensions ---

    def loop_head(self, kind: str, generators: list[ast.comprehension]) -> list[Code]:
        """Head and clauses of a comprehension."""
        nested = len(generators) > 1
        clauses: list[Code] = []
        for generator in generators:
            clauses += self.clauses(generator.target, generator.iter, parallel=not nested)
            for condition in generator.ifs:
                clauses += self.condition_clause(condition)
        return [Name(f"for{'*' if nested else ''}{kind}"), FormCode(clauses)]

    def condition_clause(self, condition: ast.expr, holds: bool = True) -> list[Code]:
        """``:when test``, or ``:unless`` of what is negated."""
        while isinstance(condition, ast.UnaryOp) and isinstance(condition.op, ast.Not):
            condition, holds = condition.operand, not holds
        return [Key("when" if holds else "unless"), self.test(condition)]

    def clauses(self, target: ast.expr, iterable: ast.expr, parallel: bool) -> list[Code]:
        """The clauses of ``for target in iterable``; ``zip`` runs side by side where that is allowed."""
        path = self.paths.of(iterable.func) if isinstance(iterable, ast.Call) else None
        if (
            parallel
            and path == "zip"
            and isinstance(iterable, ast.Call)
            and isinstance(target, (ast.Tuple, ast.List))
            and len(target.elts) == len(iterable.args)
            and not any(isinstance(e, ast.Starred) for e in (*target.elts, *iterable.args))
        ):
            sources = self.side_by_side(iterable.args)
            return [FormCode([self.pattern(t), source]) for t, source in zip(target.elts, sources)]
        return [FormCode([self.pattern(target), self.iterable(iterable)])]

    def side_by_side(self, sources: Sequence[ast.expr]) -> list[Code]:
        """The sequences of a ``zip``; ``cycle(xs)`` is repeated as often as the first other one has items."""
        is_cycle = [isinstance(s, ast.Call) and self.paths.of(s.func) == "itertools.cycle" for s in sources]
        other = next((s for s, cycles in zip(sources, is_cycle) if not cycles), None)
        codes: list[Code] = []
        for source, cycles in zip(sources, is_cycle):
            if cycles and other is not None and isinstance(source, ast.Call) and len(source.args) == 1:
                if self.effect(other).acts:
                    raise self.unsupported("`cycle` beside something that draws", source)
                codes.append(form("repeat", self.iterable(source.args[0]), form("length", self.iterable(other))))
            else:
                codes.append(self.iterable(source))
        return codes

    def pattern(self, target: ast.expr) -> Code:
        """What a ``for`` or an assignment binds: a variable or a nested pattern; a star may only end it."""
        if isinstance(target, ast.Name):
            variable = self.names.variables[target]
            return self.binder(variable, target)
        if isinstance(target, (ast.Tuple, ast.List)):
            elements = target.elts
            if any(isinstance(e, ast.Starred) for e in elements[:-1]):
                raise self.unsupported("a star before the end of this target", target)
            if elements and isinstance(elements[-1], ast.Starred):
                return FormCode(
                    [self.pattern(e) for e in elements[:-1]], self.span(target), self.pattern(elements[-1].value)
                )
            return FormCode([self.pattern(e) for e in elements], self.span(target))
        raise self.unsupported("this target", target)

    def binder(self, variable: PythonVariable, node: ast.AST) -> Code:
        """``_`` where nothing reads the variable and it says so itself."""
        if variable in self.late:
            return VariableRef(self.late[variable], self.span(node))
        if variable.name == "_" and not variable.reads:
            return Name("_", self.span(node))
        return VariableRef(variable, self.span(node))

    def _late_variables(self, node: Comprehension) -> list[PythonVariable]:
        """The variables of a comprehension that functions among its results read when they are called later."""
        targets = [n for g in node.generators for n in ast.walk(g.target) if isinstance(n, ast.Name)]
        found = (self.names.variables.get(n) for n in targets)
        return [variable for variable in dict.fromkeys(found) if variable is not None and variable.is_cell]

    def _late(self, node: Comprehension, late: list[PythonVariable], result: Code) -> Code:
        """A comprehension whose variables are the same in all turns, as functions that outlive their turn see them:
        lists joined in a loop that assigns the variables."""
        temporaries = {variable: PythonVariable(variable.name, None, is_temporary=True) for variable in late}
        self.late.update(temporaries)
        code: Code = form("list", result)
        for generator in reversed(node.generators):
            if generator.ifs:
                tests = [self.test(condition) for condition in generator.ifs]
                test = tests[0] if len(tests) == 1 else form("and", *tests)
                code = form("if", test, code, quote(FormCode([])))
            own = {self.names.variables.get(n) for n in ast.walk(generator.target)}
            sets = [form("set!", VariableRef(v), VariableRef(temporaries[v])) for v in late if v in own]
            clause = FormCode([self.pattern(generator.target), self.iterable(generator.iter)])
            code = FormCode([Name("for/append"), FormCode([clause]), *sets, code])
        for variable in late:
            del self.late[variable]
        return form("let", FormCode([FormCode([VariableRef(variable), none()]) for variable in late]), code)

    def _ListComp(self, node: ast.ListComp) -> Code:
        late = self._late_variables(node)
        if late:
            joined = self._late(node, late, self.expr(node.elt))
            return form("mutable", joined) if self.is_mutated(node) else joined
        kind = "/union" if self.is_parts(node) else "/list"
        head = self.loop_head(kind, node.generators)
        code = FormCode([*head, self.comment_item(self.expr(node.elt), node.elt)])
        return form("mutable", code) if self.is_mutated(node) else code

    def _GeneratorExp(self, node: ast.GeneratorExp) -> Code:
        late = self._late_variables(node)
        if late:
            return self._late(node, late, self.expr(node.elt))
        kind = "/union" if self.is_parts(node) else "/list"
        head = self.loop_head(kind, node.generators)
        return FormCode([*head, self.comment_item(self.expr(node.elt), node.elt)])

    def _SetComp(self, node: ast.SetComp) -> Code:
        late = self._late_variables(node)
        if late:
            return form("list->set", self._late(node, late, self.expr(node.elt)))
        return FormCode([*self.loop_head("/set", node.generators), self.expr(node.elt)])

    def _DictComp(self, node: ast.DictComp) -> Code:
        late = self._late_variables(node)
        if late:
            pair = form("list", self.expr(node.key), self.expr(node.value))
            return form("list->table", self._late(node, late, pair))
        head = self.loop_head("/table", node.generators)
        return FormCode([*head, form("list", self.expr(node.key), self.expr(node.value))])

    # --- vectors ---

    def vector(self, node: ast.expr) -> Code:
        """An expression where three numbers (or a colour) are wanted: displays become brackets."""
        if isinstance(node, (ast.Tuple, ast.List)) and node.elts and not self.is_mutated(node):
            if not any(isinstance(e, ast.Starred) for e in node.elts):
                items = [self.comment_item(operators.numeric(self, element), element) for element in node.elts]
                return Brackets(items, self.span(node))
        if isinstance(node, ast.Call) and len(node.args) == 1 and not isinstance(node.args[0], ast.Starred):
            path = self.paths.of(node.func)
            if path in ("numpy.array", "numpy.asarray") and not self.is_mutated(node):
                return self.vector(node.args[0])
            if path in ("tuple", "list") and self.type(node.args[0]).only(ARRAY | SEQUENCES):
                return self.vector(node.args[0])
        if isinstance(node, ast.IfExp):
            return form(
                "if", self.test(node.test), self.vector(node.body), self.vector(node.orelse), span=self.span(node)
            )
        return self.expr(node)

    def array(self, node: ast.expr) -> Code:
        """An operand of array arithmetic: sequences become arrays."""
        if isinstance(node, (ast.Tuple, ast.List)) and node.elts and not self.is_mutated(node):
            if not any(isinstance(e, ast.Starred) for e in node.elts):
                return Brackets([self.array(e) for e in node.elts], self.span(node))
        if isinstance(node, ast.Call) and self.paths.of(node.func) in ("tuple", "list") and len(node.args) == 1:
            return self.array(node.args[0])
        found = self.type(node)
        code = self.expr(node)
        if found.only(SEQUENCES) and not isinstance(code, Brackets):
            return form("array", code, span=self.span(node))
        return code

    # --- tests ---

    def test(self, node: ast.expr) -> Code:
        """An expression that only decides: what is false in Python is #f or none in the code."""
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            inner = self.test(node.operand)
            if is_form(inner, "not") and isinstance(inner, FormCode):
                return inner.items[1]
            return form("not", inner, span=self.span(node))
        if isinstance(node, ast.BoolOp):
            head = "and" if isinstance(node.op, ast.And) else "or"
            return form(head, *(self.test(value) for value in node.values), span=self.span(node))
        if isinstance(node, ast.Constant):
            return LiteralCode(bool(node.value), self.span(node))
        return operators.truth(self, node, self.type(node))

    # --- operators ---

    def _BinOp(self, node: ast.BinOp) -> Code:
        return operators.binary(self, node)

    def _UnaryOp(self, node: ast.UnaryOp) -> Code:
        return operators.unary(self, node)

    def _Compare(self, node: ast.Compare) -> Code:
        return operators.comparison(self, node)

    def _BoolOp(self, node: ast.BoolOp) -> Code:
        return operators.boolean(self, node)

    def _IfExp(self, node: ast.IfExp) -> Code:
        return form("if", self.test(node.test), self.expr(node.body), self.expr(node.orelse))

    def _Subscript(self, node: ast.Subscript) -> Code:
        return operators.subscript(self, node)

    def _JoinedStr(self, node: ast.JoinedStr) -> Code:
        return operators.interpolated(self, node)

    def _NamedExpr(self, node: ast.NamedExpr) -> Code:
        variable = self.names.variables.get(node.target)
        if variable is None:  # such as in the body of a class
            raise self.unsupported("`:=` here", node)
        return form("begin", form("set!", VariableRef(variable), self.expr(node.value)), VariableRef(variable))

    # --- iteration ---

    def iterable(self, node: ast.expr) -> Code:
        """What a loop runs through."""
        found = self.type(node)
        if found.kinds & SHAPE:
            return form("primitives", self.expr(node), span=self.span(node))
        if found.kinds & UNKNOWN and not isinstance(node, ast.Call):
            return self.dynamic("py-iter", self.expr(node))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr == "keys":
            if self.type(node.func.value).only(DICT):
                return self.expr(node.func.value)
        if _copies_view(self, node):
            assert isinstance(node, ast.Call)
            return self.expr(node.args[0])  # a list of its own, whatever happens to the table
        if isinstance(node, ast.Call) and self.paths.of(node.func) in ("list", "tuple", "iter") and len(node.args) == 1:
            if not isinstance(node.args[0], ast.Starred) and not self.is_mutated(node):
                inner = self.type(node.args[0])
                if inner.kinds & CONTAINERS and not any(s.is_mutated for s in inner.sites):
                    return self.iterable(node.args[0])
        return self.expr(node)

    def dynamic(self, operator: str, *arguments: Code) -> Code:
        """One of Python's dynamic operators, for types that inference cannot tell."""
        self.imports.add("std/python.scene")
        return form(operator, *arguments)

    # --- functions ---

    def _Lambda(self, node: ast.Lambda) -> Code:
        function = self.names.functions[node]
        bindings: list[Code] = []
        for parameter in function.parameters:
            if parameter.default is not None and not self.may_stay(parameter.default):
                variable = PythonVariable(parameter.variable.name, None, is_temporary=True)
                bindings.append(FormCode([VariableRef(variable), self.expr(parameter.default)]))
                self.defaults[parameter.default] = variable
        code = form(
            "lambda", lambda_list(self.parameters(function)), *self.lambda_locals(function), self.expr(node.body)
        )
        return form("let", FormCode(bindings), code) if bindings else code

    def lambda_locals(self, function: Function) -> list[Code]:
        """The definitions of what ``:=`` assigns inside a lambda, which is the lambda's own."""
        parameters = {parameter.variable for parameter in function.parameters}
        own = [variable for variable in function.locals.values() if variable not in parameters]
        return [form("define", VariableRef(variable), LiteralCode(None)) for variable in own]

    def may_stay(self, node: ast.expr) -> bool:
        """Whether a default gives the same whenever it is evaluated."""
        effect = self.effect(node)
        if effect.acts or effect.looks or effect.reads:
            return False
        if any(self.is_mutated(n) for n in ast.walk(node)):
            return False
        for name in ast.walk(node):
            if isinstance(name, ast.Name):
                variable = self.names.variables.get(name)
                if variable is not None and (len(variable.stores) > 1 or variable.is_cell):
                    return False
            elif isinstance(name, ast.Call) and self.paths.of(name.func) is None:
                return False
        return True

    def parameters(self, function: Function) -> FormCode:
        """The list of parameters; defaults are constants or names by now."""
        items: list[Code] = []
        rest: Code | None = None
        for parameter in function.parameters:
            variable = parameter.variable
            name = VariableRef(variable, self.span(variable.stores[0]), is_keyword=variable.is_keyword)
            if parameter.kind == "rest":
                rest = name
            elif parameter.kind == "keys":
                items += [Name("&keys"), name]
            elif parameter.default is not None:
                items.append(FormCode([name, self.default(function, variable, parameter.default)]))
            else:
                items.append(name)
        return FormCode(items, self._signature_span(function), rest)

    def _signature_span(self, function: Function) -> Span | None:
        """The place of the parameters in the Python."""
        if not function.parameters:
            return None
        first = self.span(function.parameters[0].variable.stores[0])
        last_parameter = function.parameters[-1]
        last = self.span(last_parameter.default or last_parameter.annotation or last_parameter.variable.stores[0])
        return Span(first.source, first.start, max(first.end, last.end))

    def default(self, function: Function, variable: PythonVariable, node: ast.expr) -> Code:
        """The default of a parameter; statements replaces what must be evaluated at the definition."""
        found = self.defaults.get(node)  # evaluated once, at the definition
        if found is not None:
            return VariableRef(found, self.span(node))
        return self.vector(node) if self.is_vector_literal(node) and self.wants_vector(node) else self.expr(node)

    def _Call(self, node: ast.Call) -> Code:
        path = self.paths.of(node.func)
        if path is not None:
            handler = CALLS.get(path)
            if handler is not None:
                return handler(self, node)
            self.check_path(node.func, path)
            raise self.unsupported(f"`{self.text.text(node.func)}`", node)
        if isinstance(node.func, ast.Attribute):
            return call_method(self, node, node.func)
        return call_function(self, node)

    def _Starred(self, node: ast.Starred) -> Code:
        raise self.unsupported("a star here", node)

    def _Yield(self, node: ast.Yield) -> Code:
        raise self.unsupported("`yield` inside an expression", node)

    def _Await(self, node: ast.Await) -> Code:
        raise self.unsupported("`await`", node)


def _copies_view(w: ExpressionWriter, node: ast.expr) -> bool:
    """``list(table.keys())`` and its like."""
    if not isinstance(node, ast.Call) or w.paths.of(node.func) not in ("list", "tuple") or len(node.args) != 1:
        return False
    inner = node.args[0]
    return (
        isinstance(inner, ast.Call)
        and isinstance(inner.func, ast.Attribute)
        and inner.func.attr in ("keys", "values", "items")
    )


def is_constant(node: ast.expr) -> bool:
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.USub, ast.UAdd)):
        return isinstance(node.operand, ast.Constant) and isinstance(node.operand.value, (int, float))
    return isinstance(node, ast.Constant)
