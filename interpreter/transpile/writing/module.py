"""The whole program: constants, functions, words and the root, from the Python's top level."""

from __future__ import annotations

import ast
from collections.abc import Sequence

from scenelang.grammar.datum import Span
from scenelang.interpreter.transpile.analysis.collect import PURE
from scenelang.interpreter.transpile.analysis.scopes import Function
from scenelang.interpreter.transpile.writing.blocks import Block, BlockItem
from scenelang.interpreter.transpile.writing.code import Code, LiteralCode, VariableRef, form
from scenelang.interpreter.transpile.writing.helpers import possible_words
from scenelang.interpreter.transpile.writing.statements import StatementWriter
from scenelang.interpreter.transpile.writing.writer import comment_lines, docstring_lines, text_of


class ModuleWriter(StatementWriter):
    """Writes the top level."""

    def opening_texts(self) -> list[str]:
        """The strings that open the program, which say what it is: lines of its header."""
        lines: list[str] = []
        for statement in self.text.tree.body:
            text = text_of(statement)
            if text is not None:
                lines += [*([""] if lines else []), *comment_lines(text)]
            elif not _opens(statement):
                break
        return lines

    def program(self) -> list[Code]:
        """The forms of the program in the order of the Python, the root last."""
        block = Block()
        body = self.text.tree.body
        opening = next((i for i, s in enumerate(body) if not _opens(s)), len(body))
        for statement in body[opening:]:
            self.statement(statement, block)
        forms = [self._top_form(item) for item in block.items]
        if self.analysed.root is not None and self.analysed.root.word is not None:
            scene = form("scene", LiteralCode(self.analysed.root.word), span=self._root_span())
            scene.blank = True
            forms.append(scene)
        imports: list[Code] = [form("import", LiteralCode(path)) for path in sorted(self.imports)]
        return [*imports, *forms]

    def _root_span(self) -> Span:
        assert self.analysed.root is not None
        return self.span(self.analysed.root.node)

    def _top_form(self, item: BlockItem) -> Code:
        if item.kind == "define":
            assert item.target is not None
            head = "define" if type(item.target) is VariableRef else "define-values"
            code: Code = form(head, item.target, item.value, span=item.value.span)
        else:
            code = item.value
        code.before = (*item.note.before, *code.before)
        code.after = code.after or item.note.after
        code.blank = code.blank or item.note.blank
        return code

    # --- top-level statements ----------------------------------------------------------------------------------

    def _FunctionDef_statement(self, node: ast.FunctionDef, block: Block, note: Code) -> None:
        function = self.names.functions[node]
        if function.parent is not self.names.module:
            super()._FunctionDef_statement(node, block, note)
            return
        for decorator in node.decorator_list:
            self.check_decorator(decorator)
        is_last = function.variable is None or function.variable.functions[-1] is function
        is_word = function.is_registered and self.analysed.words.get(function.word or "") is function
        if not is_word and not is_last:
            self._skip_comments(node)
            return  # replaced before anything could call it
        self.hoist_defaults(function, block)
        note.blank = True
        note.before = (*note.before, *docstring_lines(function), *_register_text(function))
        if not function.is_registered or not is_word:
            assert function.variable is not None
            block.add(BlockItem("function", self.define_function(function, function.variable), PURE, (), None, note))
            self._finish_note(note, None)
            return
        assert function.word is not None
        word = LiteralCode(function.word)
        if is_last and (function.is_called_directly or function.is_passed_on) and function.variable is not None:
            block.add(BlockItem("function", self.define_function(function, function.variable), PURE, (), None, note))
            bind = form("bind", word, VariableRef(function.variable), span=self.span(node))
            block.add(BlockItem("function", bind, PURE))
        else:
            bind = form("bind", word, self.as_lambda(function), span=self.span(node))
            block.add(BlockItem("function", bind, PURE, (), None, note))
        texts = dict.fromkeys(text for text in (function.text, function.text.partition(";")[0].strip()) if text)
        if texts and self._calls_by_text():
            for text in texts:
                if text != function.word and self.analysed.words.get(text) is function:
                    block.add(BlockItem("function", form("bind", LiteralCode(text), self._caller(function)), PURE))

    def _caller(self, function: Function) -> Code:
        return form("retrieve", LiteralCode(function.word))

    def _calls_by_text(self) -> bool:
        """Whether a word that is worked out while the program runs may be the text of a registration."""
        computed = [
            node.args[0] for node in ast.walk(self.text.tree)
            if isinstance(node, ast.Call) and self.paths.of(node.func) == "library_call" and node.args
            and not isinstance(node.args[0], ast.Constant)
        ]  # fmt: skip
        words = self.analysed.words
        return any(
            not known or any(text not in words or words[text].word != text for text in known)
            for known in (possible_words(self, node) for node in computed)
        )

    def _skip_comments(self, node: ast.FunctionDef) -> None:
        self.comments_until(node.end_lineno or node.lineno)

    def _Expr_statement(self, node: ast.Expr, block: Block, note: Code) -> None:
        if self.place.function is self.names.module:
            path = self.paths.of(node.value.func) if isinstance(node.value, ast.Call) else None
            if path in ("numpy.random.seed", "random.seed"):
                self.warn(
                    "python-ignored",
                    "a seed set here has no effect: the streams are seeded when the scene begins", node,
                    "`--seed N` sets the seed",
                )  # fmt: skip
                return
            if path in ("library_call",) and isinstance(node.value, ast.Call):
                return  # a scene that is thrown away
        super()._Expr_statement(node, block, note)

    def _If_statement(self, node: ast.If, block: Block, note: Code) -> None:
        if any(isinstance(n, ast.Name) and n.id == "__name__" for n in ast.walk(node.test)):
            self.comments_until(node.end_lineno or node.lineno)
            return
        super()._If_statement(node, block, note)

    def statements(self, body: Sequence[ast.stmt], block: Block) -> None:
        for statement in body:
            self.statement(statement, block)


def _opens(statement: ast.stmt) -> bool:
    return isinstance(statement, (ast.Import, ast.ImportFrom)) or text_of(statement) is not None


def _register_text(function: Function) -> list[str]:
    """The text that a function is registered with, unless it only repeats the name."""
    text = function.text.strip()
    is_name = text.replace(" ", "_").lower() == (function.word or "").lower()
    return text.splitlines() if text and not is_name else []
