"""Assignments: definitions, patterns, items, fields and cells."""

from __future__ import annotations

import ast
from collections.abc import Sequence

from scenelang.interpreter.transpile.analysis.collect import PURE, Effect
from scenelang.interpreter.transpile.analysis.inference import ARRAY, BOOL, DICT, LIST, POSE, SEQUENCES, SHAPE
from scenelang.interpreter.transpile.analysis.python_text import walk_tree
from scenelang.interpreter.transpile.analysis.scopes import PythonVariable, is_annotation
from scenelang.interpreter.transpile.writing.blocks import Block, BlockItem, total
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
from scenelang.interpreter.transpile.writing.operators import (
    axes,
    is_constant,
    is_mask,
    numeric,
    write_iterable,
    write_pattern,
)
from scenelang.interpreter.transpile.writing.user_calls import set_field
from scenelang.interpreter.transpile.writing.writer import Writer


def write_assign(w: Writer, node: ast.Assign, block: Block, note: Code) -> None:
    """Generate ``a = value`` or ``a = b = value``."""
    if is_annotation(w.paths, node.value):
        return
    if len(node.targets) == 1:
        _assign(w, node, node.targets[0], node.value, block, note)
        return
    first = node.targets[0]
    shared: Code
    if isinstance(first, ast.Name) and not w.names.variables[first].is_cell:
        _assign(w, node, first, node.value, block, note)
        shared = VariableRef(w.names.variables[first])
        rest = node.targets[1:]
    elif is_constant(node.value):
        for target in node.targets:
            _assign(w, node, target, node.value, block, note if target is first else Code(None))
        return
    else:
        shared = _temporary(w, w.expr(node.value), w.effect(node.value), block, note)
        rest = node.targets
    for target in rest:
        store(w, node, target, shared, PURE, block, Code(None))


def _check_generator(w: Writer, node: ast.GeneratorExp) -> None:
    """Raise an error for a generator that may read a variable after it has changed, which a list does not."""
    first = set(walk_tree(node.generators[0].iter))
    for each in walk_tree(node):
        variable = w.names.variables.get(each) if isinstance(each, ast.Name) and each not in first else None
        if variable is not None and len(variable.stores) > 1:
            raise w.unsupported(f"a generator that reads `{variable.name}`, which is assigned again,", node)


def write_annotated_assign(w: Writer, node: ast.AnnAssign, block: Block, note: Code) -> None:
    """Generate ``a: T = value``."""
    if node.value is not None:
        _assign(w, node, node.target, node.value, block, note)


def _assign(w: Writer, node: ast.stmt, target: ast.expr, value: ast.expr, block: Block, note: Code) -> None:
    """Generate ``target = value``."""
    if isinstance(value, ast.GeneratorExp):
        _check_generator(w, value)
    if isinstance(target, (ast.Tuple, ast.List)):
        if isinstance(value, (ast.Tuple, ast.List)) and _parallel(w, node, target.elts, value.elts, block, note):
            return
        _unpack(w, node, target, value, block, note)
        return
    if isinstance(target, ast.Subscript):
        effect = w.effect(target, value) | Effect(changes=True)
        is_number = bool(w.type(target.value).kinds & ARRAY) and w.type(value).only(BOOL)
        code = numeric(w, value) if is_number else w.expr(value)
        block.add_effect(set_item(w, target, code), effect, note)
        return
    store(w, node, target, w.expr(value), w.effect(value), block, note)


def store(w: Writer, node: ast.stmt, target: ast.expr, code: Code, effect: Effect, block: Block, note: Code) -> None:
    """Assign a value that is already generated."""
    if isinstance(target, ast.Name):
        variable = w.names.variables[target]
        if not variable.is_cell:
            if variable.name == "_" and not variable.reads:
                block.add_effect(code, effect, note)
            else:
                block.define(variable, code, effect, note)
        elif variable in w.cell_definitions.definitions.get(node, ()):
            writes = effect | Effect(writes=frozenset((variable,)))
            block.add(BlockItem("define", code, writes, (variable,), VariableRef(variable, w.span(target)), note))
        else:
            writes = effect | Effect(writes=frozenset((variable,)))
            block.add_effect(form("set!", VariableRef(variable), code, span=w.span(node)), writes, note)
    elif isinstance(target, ast.Subscript):
        block.add_effect(set_item(w, target, code), effect | w.effect(target) | Effect(changes=True), note)
    elif isinstance(target, ast.Attribute):
        block.add_effect(set_field(w, target, code), effect | Effect(changes=True), note)
    elif isinstance(target, (ast.Tuple, ast.List)):
        unpack_code(w, node, target, code, effect, block, note)
    else:
        raise w.unsupported("this assignment target", target)


def set_item(w: Writer, target: ast.Subscript, value: Code) -> Code:
    """Return the code of ``container[key] = value``."""
    if is_mask(w.type(target.slice)):
        array = w.expr(target.value)
        masked = form("where", w.expr(target.slice), value, w.expr(target.value))
        return form("set-ref!", array, Key("all"), masked, span=w.span(target))
    keys: list[Code] = []
    inner: ast.expr = target
    while isinstance(inner, ast.Subscript) and not isinstance(inner.slice, ast.Slice):
        if isinstance(inner.slice, ast.Tuple) and w.type(inner.value).kinds & (ARRAY | POSE):
            keys = [*axes(w, inner.slice.elts), *keys]
        elif inner is not target and w.type(inner.value).kinds & DICT:
            break
        elif inner is target or w.type(inner.value).only(SEQUENCES | ARRAY):
            keys = [numeric(w, inner.slice), *keys]
        else:
            break
        inner = inner.value
        if isinstance(inner, ast.Subscript) and _ends_path(w, inner):
            break
    if inner is target:
        assert isinstance(target.slice, ast.Slice)
        if not w.type(target.value).kinds & ARRAY:
            return _splice(w, target, value)
        keys, inner = axes(w, [target.slice]), target.value
    return form("set-ref!", w.expr(inner), *keys, value, span=w.span(target))


def _ends_path(w: Writer, node: ast.Subscript) -> bool:
    """Return whether a path of keys ends at ``node``, because a table, or an array in a list, is modified
    separately."""
    kinds = w.type(node).kinds
    return bool(kinds & DICT) or (bool(kinds & (ARRAY | POSE)) and not w.type(node.value).only(ARRAY | POSE))


def _splice(w: Writer, target: ast.Subscript, value: Code) -> Code:
    """Return the code of ``xs[a:b] = items``."""
    bounds = target.slice
    assert isinstance(bounds, ast.Slice)
    if bounds.step is not None:
        raise w.unsupported("assignment to a slice with a step", target)
    lower, upper = (w.expr(b) if b is not None else none() for b in (bounds.lower, bounds.upper))
    return form("splice!", w.expr(target.value), lower, upper, value, span=w.span(target))


def _temporary(w: Writer, code: Code, effect: Effect, block: Block, note: Code) -> VariableRef:
    variable = PythonVariable("value", None, is_temporary=True)
    block.define(variable, code, effect, note, nests=False)
    return VariableRef(variable)


def _parallel(
    w: Writer, node: ast.stmt, targets: list[ast.expr], values: list[ast.expr], block: Block, note: Code
) -> bool:
    """Generate ``a, b = x, y`` as separate definitions, with runs of constants as one ``define-values``.

    Returns whether the assignment has this form.
    """
    if len(targets) != len(values) or any(isinstance(e, ast.Starred) for e in (*targets, *values)):
        return False
    if any(not isinstance(t, ast.Name) for t in targets):
        return False
    variables = [w.names.variables[t] for t in targets]
    if _interferes(w, variables, values):
        if any(v.is_cell for v in variables):
            _through_temporaries(w, node, targets, values, block, note)
            return True
        codes = [w.expr(value) for value in values]
        _define_pattern(w, targets, form("list", *codes), w.effect(*values), block, note)
        return True
    position = 0
    while position < len(targets):
        end = position
        while end < len(targets) and is_constant(values[end]) and not variables[end].is_cell:
            end += 1
        if end - position > 1:
            data = quote(FormCode([w.expr(v) for v in values[position:end]]))
            _define_pattern(w, targets[position:end], data, PURE, block, note)
            position = end
        else:
            store(w, node, targets[position], w.expr(values[position]), w.effect(values[position]), block, note)
            position += 1
        note = Code(None)
    return True


def _interferes(w: Writer, variables: list[PythonVariable], values: list[ast.expr]) -> bool:
    """Return whether a later value reads an earlier target."""
    seen: set[PythonVariable] = set()
    for variable, value in zip(variables, values):
        if seen & w.liveness.uses(value):
            return True
        seen.add(variable)
    return False


def _through_temporaries(
    w: Writer, node: ast.stmt, targets: list[ast.expr], values: list[ast.expr], block: Block, note: Code
) -> None:
    variables = [PythonVariable("value", None, is_temporary=True) for _ in targets]
    bindings = FormCode([FormCode([VariableRef(v), w.expr(value)]) for v, value in zip(variables, values)])
    inner = Block()
    for target, variable in zip(targets, variables):
        store(w, node, target, VariableRef(variable), PURE, inner, Code(None))
    effect = w.effect(*values) | total(item.effect for item in inner.items)
    if all(item.kind == "effect" for item in inner.items):
        block.add_effect(form("let", bindings, *(item.value for item in inner.items)), effect, note)
        return
    for variable, value in zip(variables, values):
        block.define(variable, w.expr(value), w.effect(value), note, nests=False)
        note = Code(None)
    for item in inner.items:
        block.add(item)


def _unpack(w: Writer, node: ast.stmt, target: ast.Tuple | ast.List, value: ast.expr, block: Block, note: Code) -> None:
    """Generate ``a, (b, c) = value``."""
    code = write_iterable(w, value) if w.type(value).kinds & SHAPE else w.expr(value)
    unpack_code(w, node, target, code, w.effect(value), block, note)


def unpack_code(
    w: Writer, node: ast.stmt, target: ast.Tuple | ast.List, code: Code, effect: Effect, block: Block, note: Code
) -> None:
    """Unpack a value that is already generated."""
    elements = target.elts
    if sum(1 for e in elements if isinstance(e, ast.Starred)) > 1:
        raise w.error("python-syntax", "multiple starred expressions in assignment", target)
    if any(isinstance(e, ast.Starred) for e in elements[:-1]):
        _unpack_star(w, node, elements, code, effect, block, note)
        return
    names = [n for n in walk_tree(target) if isinstance(n, ast.Name)]
    is_plain = all(isinstance(e, (ast.Name, ast.Tuple, ast.List, ast.Starred)) for e in elements)
    defined = w.cell_definitions.definitions.get(node, set())
    if is_plain and all(not w.names.variables[n].is_cell or w.names.variables[n] in defined for n in names):
        _define_pattern(w, elements, code, effect, block, note)
        return
    _unpack_to_cells(w, node, target, code, effect, block, note)


def _unpack_to_cells(
    w: Writer, node: ast.stmt, target: ast.Tuple | ast.List, code: Code, effect: Effect, block: Block, note: Code
) -> None:
    """Unpack to targets that include cells, through temporary variables."""
    variables: list[PythonVariable] = []
    patterns: list[Code] = []
    defined = w.cell_definitions.definitions.get(node, set())
    rest: Code | None = None
    for element in target.elts:
        if isinstance(element, ast.Starred):
            variable = PythonVariable("rest", None, is_temporary=True)
            rest = VariableRef(variable)
            variables.append(variable)
            patterns.append(rest)
            continue
        own = w.names.variables.get(element)
        if own is not None and (not own.is_cell or own in defined):
            variables.append(own)
            patterns.append(write_pattern(w, element))
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
            store(w, node, element.value, _starred_list(w, element, VariableRef(variable)), PURE, inner, Code(None))
        else:
            store(w, node, element, VariableRef(variable), PURE, inner, Code(None))
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
    w: Writer, node: ast.stmt, elements: list[ast.expr], code: Code, effect: Effect, block: Block, note: Code
) -> None:
    """Generate ``*a, b = xs``: a slice for the starred target, and a pattern for the targets after it."""
    star = next(i for i, e in enumerate(elements) if isinstance(e, ast.Starred))
    starred = elements[star]
    assert isinstance(starred, ast.Starred)
    after = len(elements) - star - 1
    is_ignored = isinstance(starred.value, ast.Name) and not w.names.variables[starred.value].reads
    if star == 0 and is_ignored:
        _define_pattern(w, elements[1:], form("slice", code, number(-after)), effect, block, note)
        return
    source = code if type(code) is VariableRef else _temporary(w, code, effect, block, note)
    assert type(source) is VariableRef
    note = Code(None) if source is not code else note
    if star:
        pattern = FormCode([*(write_pattern(w, e) for e in elements[:star])], None, Name("_"))
        variables = tuple(
            w.names.variables[n] for e in elements[:star] for n in walk_tree(e) if isinstance(n, ast.Name)
        )
        block.add(BlockItem("define", VariableRef(source.variable), PURE, variables, pattern, note))
    middle = _starred_list(w, starred, form("slice", VariableRef(source.variable), number(star), number(-after)))
    store(w, node, starred.value, middle, PURE, block, Code(None))
    _define_pattern(
        w, elements[star + 1 :], form("slice", VariableRef(source.variable), number(-after)), PURE, block, Code(None)
    )


def _define_pattern(
    w: Writer, targets: Sequence[ast.expr], code: Code, effect: Effect, block: Block, note: Code
) -> None:
    last = targets[-1] if targets else None
    rest = last.value if isinstance(last, ast.Starred) else None
    if isinstance(last, ast.Starred) and _is_mutated_star(w, last) and isinstance(rest, ast.Name):
        temporary = PythonVariable(rest.id, None, is_temporary=True)
        pattern = FormCode([write_pattern(w, t) for t in targets[:-1]], None, VariableRef(temporary))
        names = [n for t in targets[:-1] for n in walk_tree(t) if isinstance(n, ast.Name)]
        bound = (*(w.names.variables[n] for n in names), temporary)
        block.add(BlockItem("define", code, effect, bound, pattern, note))
        block.define(w.names.variables[rest], form("mutable", VariableRef(temporary)), PURE, Code(None), nests=False)
        return
    plain = targets[:-1] if rest is not None else targets
    pattern = FormCode([write_pattern(w, t) for t in plain], None, write_pattern(w, rest) if rest is not None else None)
    variables = tuple(
        w.names.variables[n] for t in targets for n in walk_tree(t)
        if isinstance(n, ast.Name) and not (n.id == "_" and not w.names.variables[n].reads)
    )  # fmt: skip
    block.add(BlockItem("define", code, effect, variables, pattern, note))


def _is_mutated_star(w: Writer, node: ast.Starred) -> bool:
    return any(site.is_mutated and site.node is node for site in w.type(node.value).sites)


def _starred_list(w: Writer, node: ast.Starred, code: Code) -> Code:
    """Return the new list of a starred target, mutable if it is modified anywhere."""
    return form("mutable", code) if _is_mutated_star(w, node) else code


def write_augmented_assign(w: Writer, node: ast.AugAssign, block: Block, note: Code) -> None:
    """Generate ``a += value``."""
    target, inferred = node.target, w.type(node.target)
    if isinstance(node.op, ast.Add) and inferred.kinds & LIST and not inferred.kinds & ~(LIST | SHAPE):
        _extend_in_place(w, node, block, note)
        return
    if inferred.kinds & ARRAY and inferred.only(ARRAY) and any(site.is_mutated for site in inferred.sites):
        if _update_array(w, node, block, note):
            return
    load = _loaded(w, target)
    operation = ast.copy_location(ast.BinOp(load, node.op, node.value), node)
    w.facts.types[operation] = w.type(node)
    effect = w.effect(node.value, target)
    if isinstance(target, ast.Subscript):
        effect = effect | Effect(changes=True, inspects=True)
        if w.effect(target.value, target.slice).has_effect:
            raise w.unsupported("an augmented assignment whose index has side effects", node)
    store(w, node, target, w.expr(operation), effect, block, note)


def _loaded(w: Writer, target: ast.expr) -> ast.expr:
    """Return an expression that reads an assignment target."""
    load: ast.expr
    if isinstance(target, ast.Name):
        load = ast.Name(target.id, ast.Load())
        w.names.variables[load] = w.names.variables[target]
    elif isinstance(target, ast.Subscript):
        load = ast.Subscript(target.value, target.slice, ast.Load())
    elif isinstance(target, ast.Attribute):
        load = ast.Attribute(target.value, target.attr, ast.Load())
    else:
        raise w.unsupported("this assignment target", target)
    w.facts.types[load] = w.type(target)
    return ast.copy_location(load, target)


def _extend_in_place(w: Writer, node: ast.AugAssign, block: Block, note: Code) -> None:
    effect = w.effect(node.value) | Effect(changes=True)
    target = _loaded(w, node.target)
    if (
        isinstance(node.value, ast.List)
        and len(node.value.elts) == 1
        and not isinstance(node.value.elts[0], ast.Starred)
    ):
        code = form("push!", w.expr(target), w.expr(node.value.elts[0]), span=w.span(node))
    else:
        code = form("extend!", w.expr(target), write_iterable(w, node.value), span=w.span(node))
    block.add_effect(code, effect, note)


def _update_array(w: Writer, node: ast.AugAssign, block: Block, note: Code) -> bool:
    """Generate ``a += b`` as an in-place modification of an array, which other references observe."""
    target = node.target
    if isinstance(target, ast.Subscript) and (
        isinstance(target.slice, (ast.Slice, ast.Tuple))
        or w.type(target.value).only(ARRAY | POSE)  # a row, which is stored as a whole
        or w.effect(target.value, target.slice).has_effect
    ):
        return False
    load = _loaded(w, target)
    operation = ast.copy_location(ast.BinOp(load, node.op, node.value), node)
    w.facts.types[operation] = w.type(node)
    code = form("set-ref!", w.expr(load), Key("all"), w.expr(operation), span=w.span(node))
    block.add_effect(code, w.effect(node.value) | Effect(changes=True, inspects=True), note)
    return True
