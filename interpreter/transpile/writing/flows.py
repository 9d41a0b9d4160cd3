"""Where values go: whether a list of shapes is only united, whether a sequence of numbers only serves as a vector."""

from __future__ import annotations

import ast

from scenelang.interpreter.transpile.analysis.domain import (
    ARRAY,
    LIST,
    SHAPE,
    Type,
)
from scenelang.interpreter.transpile.analysis.scopes import Variable
from scenelang.interpreter.transpile.writing.writer import Writer


class Flows(Writer):
    """Judges by the uses of a value how it is best written."""

    # --- shapes ---

    def is_parts(self, node: ast.expr) -> bool:
        """Whether a list of shapes is only ever united, so that parts do as well."""
        sites = self.type(node).sites
        if not sites or any(not s.element.only(SHAPE) and not _is_empty_list(s.element) for s in sites):
            return False
        if not any(s.element.kinds & SHAPE for s in sites):
            return False
        parent = self.parent(node)
        if isinstance(parent, ast.Starred):
            return self._unites(parent)
        if isinstance(parent, ast.Call):
            return self._unites_argument(parent, node)
        if isinstance(parent, (ast.Assign, ast.AnnAssign)):
            target = parent.targets[0] if isinstance(parent, ast.Assign) else parent.target
            variable = self.variable(target)
            return variable is not None and self.is_united(variable)
        if isinstance(parent, ast.Return):
            return self._returns_shape(parent)
        return False

    def is_united(self, variable: Variable) -> bool:
        """Whether all that happens to the list in ``variable`` is that its shapes are united."""
        reads = self.reads_of(variable)
        return bool(reads) and all(self._read_unites(read) for read in reads)

    def _read_unites(self, read: ast.Name) -> bool:
        parent = self.parent(read)
        if isinstance(parent, ast.Starred):
            return self._unites(parent)
        if isinstance(parent, ast.Call):
            return self._unites_argument(parent, read)
        if isinstance(parent, ast.Attribute):  # the additions of a collection
            grand = self.parent(parent)
            return grand in self.analysed.collections.additions
        if isinstance(parent, ast.Return):
            return self._returns_shape(parent)
        return False

    def _returns_shape(self, node: ast.Return) -> bool:
        outer: ast.AST | None = node
        while outer is not None and not isinstance(outer, (ast.FunctionDef, ast.Module)):
            outer = self.parent(outer)
        function = self.names.functions.get(outer) if outer is not None else None
        if function is None or function.is_animation:  # the items that an animation returns are frames
            return False
        return function.is_registered and not function.is_called_directly

    def _unites(self, starred: ast.Starred) -> bool:
        call = self.parent(starred)
        return isinstance(call, ast.Call) and self.paths.of(call.func) == "concat_shapes"

    def _unites_argument(self, call: ast.Call, node: ast.expr) -> bool:
        path = self.paths.of(call.func)
        return path == "concat_shapes" or (path == "transform_shape" and bool(call.args) and call.args[0] is node)

    # --- vectors ---

    def wants_vector(self, node: ast.expr) -> bool:
        """Whether a display flows only to places that want a vector."""
        return self._flows_to_vector(node, set())

    def _flows_to_vector(self, node: ast.AST, seen: set[object]) -> bool:
        parent = self.parent(node)
        if isinstance(parent, ast.IfExp) and node is not parent.test:
            return self._flows_to_vector(parent, seen)
        if isinstance(parent, ast.Assign) and len(parent.targets) == 1 and isinstance(parent.targets[0], ast.Name):
            return self._variable_wants_vector(self.names.variables.get(parent.targets[0]), seen)
        if isinstance(parent, ast.AnnAssign):
            return self._variable_wants_vector(self.names.variables.get(parent.target), seen)
        if isinstance(parent, ast.arguments):
            function = self.names.functions.get(self.parent(parent) or parent)
            parameters = function.parameters if function is not None else []
            found = next((p for p in parameters if p.default is node), None)
            return found is not None and self._variable_wants_vector(found.variable, seen)
        if isinstance(parent, ast.keyword):
            call = self.parent(parent)
            if isinstance(call, ast.Call):
                if _is_vector_keyword(self.paths.of(call.func), parent.arg):
                    return True
                return self._parameter_wants_vector(call, parent.arg, None, seen)
            return False
        if isinstance(parent, ast.Dict):
            position = next((i for i, v in enumerate(parent.values) if v is node), None)
            key = parent.keys[position] if position is not None else None
            is_attribute = isinstance(key, ast.Constant) and key.value in ("p0", "p1", "scale")
            holder = self.parent(parent)
            return is_attribute and isinstance(holder, (ast.keyword, ast.Call))
        if isinstance(parent, ast.Call):
            path = self.paths.of(parent.func)
            position = next((i for i, a in enumerate(parent.args) if a is node), None)
            if position is None:
                return False
            if path is not None:
                return _is_vector_argument(path, position)
            return self._parameter_wants_vector(parent, None, position, seen)
        if isinstance(parent, ast.BinOp):
            other = parent.right if parent.left is node else parent.left
            return self.type(other).only(ARRAY)
        if isinstance(parent, ast.Subscript) and parent.value is node:
            return isinstance(parent.ctx, ast.Load)
        return False

    def _parameter_wants_vector(
        self, call: ast.Call, name: str | None, position: int | None, seen: set[object]
    ) -> bool:
        targets = self.facts.targets.get(call, [])
        if not targets:
            return False
        for target in targets:
            if name is not None:
                parameter = target.parameter(name)
            else:
                plain = [p for p in target.parameters if p.kind == "plain"]
                parameter = plain[position] if position is not None and position < len(plain) else None
            if parameter is None or not self._variable_wants_vector(parameter.variable, seen):
                return False
        return True

    def _variable_wants_vector(self, variable: Variable | None, seen: set[object]) -> bool:
        if variable is None or variable.is_assigned_elsewhere:
            return False
        if variable in seen:
            return True
        seen.add(variable)
        reads = self.reads_of(variable)
        return bool(reads) and all(self._flows_to_vector(read, seen) or self._is_unpacked(read) for read in reads)

    def _is_unpacked(self, read: ast.Name) -> bool:
        parent = self.parent(read)
        return isinstance(parent, ast.Assign) and isinstance(parent.targets[0], ast.Tuple) and parent.value is read


def _is_empty_list(found: Type) -> bool:
    return found.only(SHAPE | LIST) and all(not site.element.kinds & ~SHAPE for site in found.sites)


_VECTOR_KEYWORDS = {
    "primitive_call": ("color", "scale"),
    "translation_matrix": ("offset",),
    "rotation_matrix": ("direction", "point"),
    "scale_matrix": ("scale", "origin"),
    "reflection_matrix": ("point", "normal"),
}
_VECTOR_ARGUMENTS = {
    "primitive_call": (2,),
    "translation_matrix": (0,),
    "rotation_matrix": (1, 2),
    "scale_matrix": (0, 1),
    "reflection_matrix": (0, 1),
    "numpy.array": (0,),
    "numpy.asarray": (0,),
    "numpy.linalg.norm": (0,),
    "numpy.dot": (0, 1),
    "numpy.cross": (0, 1),
}


def _is_vector_keyword(path: str | None, name: str | None) -> bool:
    return path is not None and name in _VECTOR_KEYWORDS.get(path, ())


def _is_vector_argument(path: str, position: int) -> bool:
    return position in _VECTOR_ARGUMENTS.get(path, ())
