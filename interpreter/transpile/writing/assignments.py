"""Assignments: definitions, patterns, items, fields, and what is assigned in place."""

from __future__ import annotations

import ast
from collections.abc import Sequence

from scenelang.interpreter.transpile.analysis.collect import PURE, Effect
from scenelang.interpreter.transpile.analysis.inference import ARRAY, BOOL, DICT, LIST, POSE, SEQUENCES, SHAPE
from scenelang.interpreter.transpile.analysis.scopes import PythonVariable, is_annotation
from scenelang.interpreter.transpile.writing.blocks import Block, BlockItem, total
from scenelang.interpreter.transpile.writing.bodies import BodyWriter
from scenelang.interpreter.transpile.writing.code import (
    Code,
    FormCode,
    Key,
    Name,
    VariableRef,
    form,
    none,
    number,
    quote,
)
from scenelang.interpreter.transpile.writing.expressions import is_constant
from scenelang.interpreter.transpile.writing.operators import axes, is_mask, numeric
from scenelang.interpreter.transpile.writing.user_calls import write_field


class AssignmentWriter(BodyWriter):
    """Writes assignments."""

    def _Assign_statement(self, node: ast.Assign, block: Block, note: Code) -> None:
        if is_annotation(self.paths, node.value):
            return
        collection = self.analysed.collections.by_start.get(node)
        if collection is not None:
            self._start(collection, node.value, block, note)
            return
        if len(node.targets) == 1:
            self.assign(node, node.targets[0], node.value, block, note)
            return
        first = node.targets[0]
        shared: Code
        if isinstance(first, ast.Name) and not self.names.variables[first].is_cell:
            self.assign(node, first, node.value, block, note)
            shared = VariableRef(self.names.variables[first])
            rest = node.targets[1:]
        elif is_constant(node.value):
            for target in node.targets:
                self.assign(node, target, node.value, block, note if target is first else Code(None))
            return
        else:
            shared = self._temporary(self.expr(node.value), self.effect(node.value), block, note)
            rest = node.targets
        for target in rest:
            self.store(node, target, shared, PURE, block, Code(None))

    def _AnnAssign_statement(self, node: ast.AnnAssign, block: Block, note: Code) -> None:
        if node.value is None:
            return
        collection = self.analysed.collections.by_start.get(node)
        if collection is not None:
            self._start(collection, node.value, block, note)
        else:
            self.assign(node, node.target, node.value, block, note)

    def assign(self, node: ast.stmt, target: ast.expr, value: ast.expr, block: Block, note: Code) -> None:
        """``target = value``."""
        if isinstance(target, (ast.Tuple, ast.List)):
            if isinstance(value, (ast.Tuple, ast.List)) and self._parallel(node, target.elts, value.elts, block, note):
                return
            self.unpack(node, target, value, block, note)
            return
        if isinstance(target, ast.Subscript):
            effect = self.effect(target, value) | Effect(changes=True)
            is_number = bool(self.type(target.value).kinds & ARRAY) and self.type(value).only(BOOL)
            code = numeric(self, value) if is_number else self.expr(value)
            block.add_effect(self.set_item(target, code), effect, note)
            return
        self.store(node, target, self.expr(value), self.effect(value), block, note)

    def store(self, node: ast.stmt, target: ast.expr, code: Code, effect: Effect, block: Block, note: Code) -> None:
        """Assign a value that is written already."""
        if isinstance(target, ast.Name):
            variable = self.names.variables[target]
            if not variable.is_cell:
                if variable.name == "_" and not variable.reads:
                    block.add_effect(code, effect, note)
                else:
                    block.define(variable, code, effect, note)
            elif variable in self.places.definitions.get(node, ()):
                writes = effect | Effect(writes=frozenset((variable,)))
                block.add(
                    BlockItem("define", code, writes, (variable,), VariableRef(variable, self.span(target)), note)
                )
            else:
                writes = effect | Effect(writes=frozenset((variable,)))
                block.add_effect(form("set!", VariableRef(variable), code, span=self.span(node)), writes, note)
        elif isinstance(target, ast.Subscript):
            block.add_effect(self.set_item(target, code), effect | self.effect(target) | Effect(changes=True), note)
        elif isinstance(target, ast.Attribute):
            block.add_effect(write_field(self, target, code), effect | Effect(changes=True), note)
        elif isinstance(target, (ast.Tuple, ast.List)):
            self._unpack_code(node, target, code, effect, block, note)
        else:
            raise self.unsupported("this target", target)

    def set_item(self, target: ast.Subscript, value: Code) -> Code:
        """``container[key] = value``."""
        if is_mask(self.type(target.slice)):
            array = self.expr(target.value)
            masked = form("where", self.expr(target.slice), value, self.expr(target.value))
            return form("set-ref!", array, Key("all"), masked, span=self.span(target))
        keys: list[Code] = []
        inner: ast.expr = target
        while isinstance(inner, ast.Subscript) and not isinstance(inner.slice, ast.Slice):
            if isinstance(inner.slice, ast.Tuple) and self.type(inner.value).kinds & (ARRAY | POSE):
                keys = [*axes(self, inner.slice.elts), *keys]
            elif inner is not target and self.type(inner.value).kinds & DICT:
                break
            elif inner is target or self.type(inner.value).only(SEQUENCES | ARRAY):
                keys = [numeric(self, inner.slice), *keys]
            else:
                break
            inner = inner.value
            if isinstance(inner, ast.Subscript) and self._ends_path(inner):
                break
        if inner is target:
            assert isinstance(target.slice, ast.Slice)
            if not self.type(target.value).kinds & ARRAY:
                return self._splice(target, value)
            keys, inner = axes(self, [target.slice]), target.value
        return form("set-ref!", self.expr(inner), *keys, value, span=self.span(target))

    def _ends_path(self, node: ast.Subscript) -> bool:
        """Whether a path of keys ends at ``node``: a table, or an array in a list, is changed by itself."""
        kinds = self.type(node).kinds
        return bool(kinds & DICT) or (bool(kinds & (ARRAY | POSE)) and not self.type(node.value).only(ARRAY | POSE))

    def _splice(self, target: ast.Subscript, value: Code) -> Code:
        """``xs[a:b] = items``."""
        bounds = target.slice
        assert isinstance(bounds, ast.Slice)
        if bounds.step is not None:
            raise self.unsupported("assigning a slice with a step", target)
        lower, upper = (self.expr(b) if b is not None else none() for b in (bounds.lower, bounds.upper))
        return form("splice!", self.expr(target.value), lower, upper, value, span=self.span(target))

    def _temporary(self, code: Code, effect: Effect, block: Block, note: Code) -> VariableRef:
        variable = PythonVariable("value", None, is_temporary=True)
        block.define(variable, code, effect, note, nests=False)
        return VariableRef(variable)

    def _parallel(
        self, node: ast.stmt, targets: list[ast.expr], values: list[ast.expr], block: Block, note: Code
    ) -> bool:
        """``a, b = x, y`` as separate definitions; runs of constants as one ``define-values``."""
        if len(targets) != len(values) or any(isinstance(e, ast.Starred) for e in (*targets, *values)):
            return False
        if any(not isinstance(t, ast.Name) for t in targets):
            return False
        variables = [self.names.variables[t] for t in targets]
        if self._interferes(variables, values):
            if any(v.is_cell for v in variables):
                self._through_temporaries(node, targets, values, block, note)
                return True
            codes = [self.expr(value) for value in values]
            self._define_pattern(targets, form("list", *codes), self.effect(*values), block, note)
            return True
        position = 0
        while position < len(targets):
            end = position
            while end < len(targets) and is_constant(values[end]) and not variables[end].is_cell:
                end += 1
            if end - position > 1:
                data = quote(FormCode([self.expr(v) for v in values[position:end]]))
                self._define_pattern(targets[position:end], data, PURE, block, note)
                position = end
            else:
                self.store(
                    node, targets[position], self.expr(values[position]), self.effect(values[position]), block, note
                )
                position += 1
            note = Code(None)
        return True

    def _interferes(self, variables: list[PythonVariable], values: list[ast.expr]) -> bool:
        """Whether a later value reads an earlier target."""
        seen: set[PythonVariable] = set()
        for variable, value in zip(variables, values):
            if seen & self.liveness.uses(value):
                return True
            seen.add(variable)
        return False

    def _through_temporaries(
        self, node: ast.stmt, targets: list[ast.expr], values: list[ast.expr], block: Block, note: Code
    ) -> None:
        variables = [PythonVariable("value", None, is_temporary=True) for _ in targets]
        bindings = FormCode([FormCode([VariableRef(v), self.expr(value)]) for v, value in zip(variables, values)])
        inner = Block()
        for target, variable in zip(targets, variables):
            self.store(node, target, VariableRef(variable), PURE, inner, Code(None))
        effect = self.effect(*values) | total(item.effect for item in inner.items)
        if all(item.kind == "effect" for item in inner.items):
            block.add_effect(form("let", bindings, *(item.value for item in inner.items)), effect, note)
            return
        for variable, value in zip(variables, values):
            block.define(variable, self.expr(value), self.effect(value), note, nests=False)
            note = Code(None)
        for item in inner.items:
            block.add(item)

    def unpack(self, node: ast.stmt, target: ast.Tuple | ast.List, value: ast.expr, block: Block, note: Code) -> None:
        """``a, (b, c) = value``."""
        code = self.iterable(value) if self.type(value).kinds & SHAPE else self.expr(value)
        self._unpack_code(node, target, code, self.effect(value), block, note, value)

    def _unpack_code(
        self, node: ast.stmt, target: ast.Tuple | ast.List, code: Code, effect: Effect, block: Block, note: Code,
        value: ast.expr | None = None,
    ) -> None:  # fmt: skip
        elements = target.elts
        if sum(1 for e in elements if isinstance(e, ast.Starred)) > 1:
            raise self.error("python-syntax", "two stars in one target", target)
        star = next((i for i, e in enumerate(elements) if isinstance(e, ast.Starred)), None)
        if star is not None and star < len(elements) - 1:
            self._unpack_star(node, elements, star, code, effect, block, note)
            return
        names = [n for n in ast.walk(target) if isinstance(n, ast.Name)]
        is_plain = all(isinstance(e, (ast.Name, ast.Tuple, ast.List, ast.Starred)) for e in elements)
        defined = self.places.definitions.get(node, set())
        if is_plain and all(not self.names.variables[n].is_cell or self.names.variables[n] in defined for n in names):
            self._define_pattern(elements, code, effect, block, note)
            return
        self._unpack_to_cells(node, target, code, effect, block, note)

    def _unpack_to_cells(
        self, node: ast.stmt, target: ast.Tuple | ast.List, code: Code, effect: Effect, block: Block, note: Code
    ) -> None:
        """Targets that are assigned in place get their values from temporaries."""
        variables: list[PythonVariable] = []
        patterns: list[Code] = []
        defined = self.places.definitions.get(node, set())
        rest: Code | None = None
        for element in target.elts:
            if isinstance(element, ast.Starred):
                variable = PythonVariable("rest", None, is_temporary=True)
                rest = VariableRef(variable)
                variables.append(variable)
                patterns.append(rest)
                continue
            own = self.names.variables.get(element)
            if own is not None and (not own.is_cell or own in defined):
                variables.append(own)
                patterns.append(self.pattern(element))
                continue
            is_ignored = own is not None and own.name == "_" and not own.reads
            name = element.id if isinstance(element, ast.Name) else "value"
            variable = PythonVariable(name, None, is_temporary=True)
            variables.append(variable)
            patterns.append(Name("_") if is_ignored else VariableRef(variable))
        inner = Block()
        for element, variable, pattern in zip(target.elts, variables, patterns):
            if type(pattern) is not VariableRef or not variable.is_temporary:
                continue
            if isinstance(element, ast.Starred):
                self.store(
                    node, element.value, self._starred_list(element, VariableRef(variable)), PURE, inner, Code(None)
                )
            else:
                self.store(node, element, VariableRef(variable), PURE, inner, Code(None))
        plain = patterns[:-1] if rest is not None else patterns
        whole = FormCode(plain, None, rest)
        if all(item.kind == "effect" for item in inner.items) and all(v.is_temporary for v in variables):
            bindings = FormCode([FormCode([whole, code])])
            total_effect = effect | total(item.effect for item in inner.items)
            block.add_effect(form("let", bindings, *(item.value for item in inner.items)), total_effect, note)
            return
        block.add(BlockItem("define", code, effect, tuple(variables), whole, note))
        for item in inner.items:
            block.add(item)

    def _unpack_star(
        self, node: ast.stmt, elements: list[ast.expr], star: int, code: Code, effect: Effect, block: Block, note: Code
    ) -> None:
        """``*a, b = xs``: a slice for the star, a pattern for what stands behind it."""
        starred = elements[star]
        assert isinstance(starred, ast.Starred)
        after = len(elements) - star - 1
        is_ignored = isinstance(starred.value, ast.Name) and not self.names.variables[starred.value].reads
        if star == 0 and is_ignored:
            self._define_pattern(elements[1:], form("slice", code, number(-after)), effect, block, note)
            return
        source = code if type(code) is VariableRef else self._temporary(code, effect, block, note)
        assert type(source) is VariableRef
        note = Code(None) if source is not code else note
        if star:
            pattern = FormCode([*(self.pattern(e) for e in elements[:star])], None, Name("_"))
            variables = tuple(
                self.names.variables[n] for e in elements[:star] for n in ast.walk(e) if isinstance(n, ast.Name)
            )
            block.add(BlockItem("define", VariableRef(source.variable), PURE, variables, pattern, note))
        middle = self._starred_list(starred, form("slice", VariableRef(source.variable), number(star), number(-after)))
        self.store(node, starred.value, middle, PURE, block, Code(None))
        self._define_pattern(
            elements[star + 1 :], form("slice", VariableRef(source.variable), number(-after)), PURE, block, Code(None)
        )

    def _define_pattern(
        self, targets: Sequence[ast.expr], code: Code, effect: Effect, block: Block, note: Code
    ) -> None:
        last = targets[-1] if targets else None
        rest = last.value if isinstance(last, ast.Starred) else None
        if isinstance(last, ast.Starred) and self._is_mutated_star(last) and isinstance(rest, ast.Name):
            given = PythonVariable(rest.id, None, is_temporary=True)
            pattern = FormCode([self.pattern(t) for t in targets[:-1]], None, VariableRef(given))
            names = [n for t in targets[:-1] for n in ast.walk(t) if isinstance(n, ast.Name)]
            bound = (*(self.names.variables[n] for n in names), given)
            block.add(BlockItem("define", code, effect, bound, pattern, note))
            block.define(self.names.variables[rest], form("mutable", VariableRef(given)), PURE, Code(None), nests=False)
            return
        plain = targets[:-1] if rest is not None else targets
        pattern = FormCode([self.pattern(t) for t in plain], None, self.pattern(rest) if rest is not None else None)
        variables = tuple(
            self.names.variables[n] for t in targets for n in ast.walk(t)
            if isinstance(n, ast.Name) and not (n.id == "_" and not self.names.variables[n].reads)
        )  # fmt: skip
        block.add(BlockItem("define", code, effect, variables, pattern, note))

    def _is_mutated_star(self, node: ast.Starred) -> bool:
        return any(site.is_mutated and site.node is node for site in self.type(node.value).sites)

    def _starred_list(self, node: ast.Starred, code: Code) -> Code:
        """What a star takes is a new list, which may change."""
        return form("mutable", code) if self._is_mutated_star(node) else code

    def _AugAssign_statement(self, node: ast.AugAssign, block: Block, note: Code) -> None:
        target, found = node.target, self.type(node.target)
        if isinstance(node.op, ast.Add) and found.kinds & LIST and not found.kinds & ~(LIST | SHAPE):
            self._extend_in_place(node, block, note)
            return
        if found.kinds & ARRAY and found.only(ARRAY) and any(site.is_mutated for site in found.sites):
            if self._update_array(node, block, note):
                return
        load = self.loaded(target)
        operation = ast.copy_location(ast.BinOp(load, node.op, node.value), node)
        self.facts.types[operation] = self.type(node)
        effect = self.effect(node.value, target)
        if isinstance(target, ast.Subscript):
            effect = effect | Effect(changes=True, looks=True)
            if self.effect(target.value, target.slice).acts:
                raise self.unsupported("updating an item whose index does something", node)
        self.store(node, target, self.expr(operation), effect, block, note)

    def loaded(self, target: ast.expr) -> ast.expr:
        """The same place, read."""
        load: ast.expr
        if isinstance(target, ast.Name):
            load = ast.Name(target.id, ast.Load())
            self.names.variables[load] = self.names.variables[target]
        elif isinstance(target, ast.Subscript):
            load = ast.Subscript(target.value, target.slice, ast.Load())
        elif isinstance(target, ast.Attribute):
            load = ast.Attribute(target.value, target.attr, ast.Load())
        else:
            raise self.unsupported("this target", target)
        self.facts.types[load] = self.type(target)
        return ast.copy_location(load, target)

    def _extend_in_place(self, node: ast.AugAssign, block: Block, note: Code) -> None:
        effect = self.effect(node.value) | Effect(changes=True)
        target = self.loaded(node.target)
        if (
            isinstance(node.value, ast.List)
            and len(node.value.elts) == 1
            and not isinstance(node.value.elts[0], ast.Starred)
        ):
            code = form("push!", self.expr(target), self.expr(node.value.elts[0]), span=self.span(node))
        else:
            code = form("extend!", self.expr(target), self.iterable(node.value), span=self.span(node))
        block.add_effect(code, effect, note)

    def _update_array(self, node: ast.AugAssign, block: Block, note: Code) -> bool:
        """``a += b`` changes the array itself, which others may see."""
        target = node.target
        if isinstance(target, ast.Subscript) and (
            isinstance(target.slice, (ast.Slice, ast.Tuple)) or self.effect(target.value, target.slice).acts
        ):
            return False
        load = self.loaded(target)
        operation = ast.copy_location(ast.BinOp(load, node.op, node.value), node)
        self.facts.types[operation] = self.type(node)
        code = form("set-ref!", self.expr(load), Key("all"), self.expr(operation), span=self.span(node))
        block.add_effect(code, self.effect(node.value) | Effect(changes=True, looks=True), note)
        return True
