"""Inference through calls: of functions of the program, its classes, the library and methods."""

from __future__ import annotations

import ast

from scenelang.interpreter.transpile.analysis.domain import (
    ANYTHING,
    DICT,
    FUNCTION,
    NOTHING,
    RECORD,
    T_SHAPE,
    T_STR,
    TUPLE,
    UNKNOWN,
    Type,
    join_all,
)
from scenelang.interpreter.transpile.analysis.inference import (
    CHANGES,
    DRAWS,
    InferenceState,
)
from scenelang.interpreter.transpile.analysis.known import METHODS, MUTATORS, RESULTS, draws
from scenelang.interpreter.transpile.analysis.scopes import Class, Function, Variable


class CallInference(InferenceState):
    """Looks at calls."""

    def _Call(self, node: ast.Call) -> Type:
        path = self.paths.of(node.func)
        positional = self._positional(node)
        named = {k.arg: self.expression(k.value) for k in node.keywords if k.arg is not None}
        for keyword in node.keywords:
            if keyword.arg is None:
                self.expression(keyword.value)
        if path is not None:
            return self._call_path(path, node, positional, named)
        if isinstance(node.func, ast.Attribute):
            return self._call_method(node, node.func, positional, named)
        return self.call(self.expression(node.func), node, positional, named)

    def _positional(self, node: ast.Call) -> list[Type]:
        positional: list[Type] = []
        for argument in node.args:
            value = self.expression(argument)
            if isinstance(argument, ast.Starred):
                sites = self.read_sites(value)
                if len(sites) == 1 and sites[0].items is not None:
                    positional += sites[0].items
                else:
                    positional += [self.elements(value)] * 8  # as many as anything could take
            else:
                positional.append(value)
        return positional

    def _call_path(self, path: str, node: ast.Call, positional: list[Type], named: dict[str, Type]) -> Type:
        self.facts.types[node.func] = Type(FUNCTION, frozenset((path,)))
        if path == "library_call":
            return self._library_call(node, positional, named)
        if draws(path):
            self.effect(node, DRAWS)
        if path == "print":
            self.effect(node, CHANGES)
        if path in MUTATORS and positional:
            self.mutated(positional[0], node=node)
        result = RESULTS.get(path)
        if result is None:
            return ANYTHING
        return result if isinstance(result, Type) else result(self, node, positional, named)

    def _library_call(self, node: ast.Call, positional: list[Type], named: dict[str, Type]) -> Type:
        word = node.args[0] if node.args else next((k.value for k in node.keywords if k.arg == "func_name"), None)
        named = {name: value for name, value in named.items() if name != "func_name"}
        if isinstance(word, ast.Constant):
            target = self.facts.words.get(str(word.value))
            targets = [target] if target is not None else []
        else:
            targets = [f for f in dict.fromkeys(self.facts.words.values()) if all(f.parameter(name) for name in named)]
        self.facts.targets[node] = targets
        stars = [k for k in node.keywords if k.arg is None]
        for target in targets:
            extra = dict(named)
            for star in stars:
                for site in self.read_sites(self.facts.type(star.value)):
                    for parameter in target.parameters:
                        if parameter.variable.name not in extra and parameter.kind != "keys":
                            known = site.fields.get(parameter.variable.name, NOTHING) | site.other
                            extra[parameter.variable.name] = known if site.fields else site.element
            self.call_function(target, node, [], extra)
        return T_SHAPE

    def _call_method(self, node: ast.Call, func: ast.Attribute, positional: list[Type], named: dict[str, Type]) -> Type:
        owner = self.expression(func.value)
        result = NOTHING
        for record in owner.classes:
            method = record.methods.get(func.attr)
            if method is not None:
                is_instance = bool(owner.kinds & RECORD) and not method.is_static
                arguments = [Type(RECORD, frozenset((record,))), *positional] if is_instance else positional
                self.facts.targets.setdefault(node, [])
                if method not in self.facts.targets[node]:
                    self.facts.targets[node].append(method)
                result = result | self.call_function(method, node, arguments, named)
            elif func.attr not in record.methods:
                site = self.site(record.node, DICT, f".{func.attr}")
                site.readers.add(self.function)
                result = result | self.call(site.element, node, positional, named)
        handler = METHODS.get(func.attr)
        if handler is not None and not owner.classes:
            result = result | handler(self, node, owner, positional, named)
        elif not owner.classes:
            result = result | ANYTHING
        return result

    def call(self, function: Type, node: ast.AST, positional: list[Type], named: dict[str, Type]) -> Type:
        """Call anything that may be a function."""
        result = ANYTHING if function.kinds & UNKNOWN else NOTHING
        for target in function.functions:
            if isinstance(node, ast.Call) and self.facts.types.get(node.func) is function:
                known = self.facts.targets.setdefault(node, [])
                if target not in known:
                    known.append(target)
            result = result | self.call_function(target, node, positional, named)
        for record in function.classes:
            result = result | self._construct(record, node, positional, named)
        for path in function.names:
            entry = RESULTS.get(path)
            if draws(path):
                self.effect(node, DRAWS)
            if isinstance(entry, Type):
                result = result | entry
            elif entry is not None:
                result = result | entry(self, node, positional, named)
        return result

    def call_function(self, function: Function, node: ast.AST, positional: list[Type], named: dict[str, Type]) -> Type:
        """Join the arguments into the parameters; what the function is known to return."""
        self.facts.callbacks.setdefault(node, set()).add(function)
        self.callees.setdefault(self.function, set()).add(function)
        self.callers.setdefault(function, set()).add(self.function)
        rest: list[Type] = []
        used: set[str] = set()
        position = 0
        for parameter in function.parameters:
            name = parameter.variable.name
            if parameter.kind == "plain" and position < len(positional):
                value = positional[position]
                position += 1
            elif parameter.kind in ("plain", "keyword") and name in named:
                value = named[name]
                used.add(name)
            elif parameter.kind == "rest":
                rest = positional[position:]
                value = self.container(parameter.annotation or function.node, TUPLE, join_all(rest), tag="*")
            elif parameter.kind == "keys":
                extra = [v for n, v in named.items() if n not in used]
                value = self.container(function.node, DICT, join_all(extra), T_STR, tag="**")
            elif parameter.default is not None:
                value = self.facts.type(parameter.default)
            else:
                continue
            self._bind(function, parameter.variable, value)
        if function not in self.facts.reached:
            self.enqueue(function)
        return self.facts.returns.get(function, NOTHING)

    def _bind(self, function: Function, variable: Variable, value: Type) -> None:
        old = self.facts.variables.get(variable, NOTHING)
        new = old | value
        if new is not old:
            self.facts.variables[variable] = new
            self.enqueue(function)
            for reader in variable.readers:
                if reader is not function:
                    self.enqueue(reader)

    def _construct(self, record: Class, node: ast.AST, positional: list[Type], named: dict[str, Type]) -> Type:
        made = Type(RECORD, frozenset((record,)))
        constructor = record.methods.get("__init__")
        if constructor is not None:
            self.call_function(constructor, node, [made, *positional], named)
        else:
            for (name, _), value in zip(record.fields, positional):
                self.set_field(record, name, value)
            for name, value in named.items():
                self.set_field(record, name, value)
        return made
