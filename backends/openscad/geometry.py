"""Modules of OpenSCAD as expressions of the Scene Language: shapes with two or three dimensions.

OpenSCAD finds out at run time whether an object is flat; here profiles and solids are different values, so a module
that is called with flat children and with solid ones is written twice. Objects may be empty in OpenSCAD, which
booleans here refuse: where that can happen, a helper leaves the empty ones out.

Converted programs get OpenSCAD's polygons, not exact spheres and cylinders: the same numbers of sides, rings half a
step from the poles, and layers of twists, so that volumes agree and parts still fit into each other.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple, NoReturn

from scenelang.backends.openscad.arithmetic import (
    ANY,
    INT,
    LEAST_RESOLUTION,
    MAX_SEGMENTS,
    NUM,
    UNKNOWN,
    Converter,
    Definition,
    Expressions,
    NameScope,
    Snippet,
    call,
    constant,
    fragments_of,
    half,
    is_number,
    long_call,
    look_of,
    number_text,
    own_name,
    vector_code,
    with_comments,
)
from scenelang.backends.openscad.syntax import (
    Branch,
    ConstantValue,
    FunctionDefinition,
    Instance,
    ModuleDefinition,
    Statement,
    assigned,
    failure,
    runs,
    unsupported,
    uses_children,
)
from scenelang.grammar.datum import Span
from scenelang.grammar.diagnostics import SceneError, suggest
from scenelang.interpreter.loading import np

_FINE = 30  # sides of a full circle from which the rounding of OpenSCAD's offsets makes no difference

# --- shapes ----------------------------------------------------------------------------------------------------------


class Shape(NamedTuple):
    """Object: its text without the movements around it, and what is known of it.

    ``dimensions`` is 0 where that is not known, or of nothing. ``moves`` are the movements, outermost first: poses of a
    solid, and pairs of a keyword and its value for a profile. ``is_list`` says that the text is a list of profiles.
    """

    text: str
    dimensions: int
    may_be_empty: bool = False
    moves: tuple[tuple[str, str], ...] = ()
    is_list: bool = False
    comments: tuple[str, ...] = ()

    @property
    def is_void(self) -> bool:
        """Whether it certainly is empty."""
        return self.text in _VOIDS.values()

    def moved(self, kind: str, text: str) -> Shape:
        return self if self.is_void else self._replace(moves=((kind, text), *self.moves))


_VOIDS = {2: "(list)", 3: "(union)"}
NOTHING = Shape("(union)", 0, True)
_ORDER = ("scale", "rotate", "move")  # in which `transform-profile` does them


def placed(c: Converter, shape: Shape) -> str:
    """Return the text of an object with its movements."""
    base = _unmoved(c, shape)
    if not shape.moves:
        return base
    if shape.dimensions != 2:
        poses = [text for _, text in shape.moves]
        return call("transform", base, poses[0] if len(poses) == 1 else call("@", *poses))
    inside, base = base, "profile" if shape.may_be_empty else base
    pending: list[tuple[str, str]] = []
    for kind, text in reversed(shape.moves):
        later = [_ORDER.index(each) for each, _ in pending]
        if kind == "matrix" or (later and _ORDER.index(kind) <= max(later)):
            base, pending = _profile_moved(base, pending), []
        if kind == "matrix":
            base = call(c.helper("profile-by-matrix"), base, text)
        else:
            pending.append((kind, text))
    base = _profile_moved(base, pending)
    if shape.may_be_empty:
        return call(c.helper("map-profile"), inside, f"(lambda (profile) {base})")
    return base


def _unmoved(c: Converter, shape: Shape) -> str:
    return _one_profile(c, shape) if shape.is_list else shape.text


def _profile_moved(base: str, moves: Sequence[tuple[str, str]]) -> str:
    if not moves:
        return base
    return call("transform-profile", base, *(f":{kind} {text}" for kind, text in moves))


def _one_profile(c: Converter, shape: Shape) -> str:
    name = c.helper("profiles-union") if shape.may_be_empty else "profile-union"
    return call("apply", name, shape.text)


def dimensions_of(shapes: Sequence[Shape], span: Span) -> int:
    """Return the dimensions that objects share, 0 if unknown."""
    dimensions = {shape.dimensions for shape in shapes} - {0}
    if len(dimensions) > 1:
        unsupported(span, "flat and solid objects together", "give the flat one a height by `linear_extrude`")
    return dimensions.pop() if dimensions else 0


# --- places ----------------------------------------------------------------------------------------------------------


_GROUPS = {"union", "group", "render", "assign", "let"}
_MOVES = {"translate", "rotate", "scale", "mirror", "multmatrix", "resize", "color"}
_BOOLEANS = {"difference", "intersection", "hull", "minkowski"}
_FLAT = {"difference": "profile-difference", "intersection": "profile-intersection", "hull": "profile-hull",
         "minkowski": "profile-minkowski"}  # fmt: skip
_SAFE = {
    ("difference", 3): "solid-cut", ("intersection", 3): "solid-common", ("hull", 3): "solid-hull",
    ("minkowski", 3): "solid-sum", ("difference", 2): "profile-cut", ("intersection", 2): "profile-common",
    ("hull", 2): "profiles-hull", ("minkowski", 2): "profile-sum",
}  # fmt: skip


class Objects(Expressions):
    """Converts statements at one place."""

    def __init__(
        self, converter: Converter, scope: NameScope, specials: Mapping[str, Snippet], owner: int, variant: int = 0
    ) -> None:  # fmt: skip
        super().__init__(converter, scope, specials, owner)
        self.variant = variant  # dimensions of the children of the module that this is inside of
        self.color = ""  # of the outermost `color` around this place
        self.children_name = ""

    def place(self, shape: Shape) -> str:
        """Return the text of an object."""
        return placed(self.c, shape)

    def commented(self, shape: Shape) -> str:
        """Return the text of an object below its comments."""
        return with_comments(shape.comments, self.place(shape))

    # --- scopes ------------------------------------------------------------------------------------------------------

    def declare(self, statements: Sequence[Statement]) -> list[tuple[tuple[str, ...], str]]:
        """Declare and convert the definitions of a scope; returns comments and texts."""
        texts: list[tuple[tuple[str, ...], str]] = []
        functions = [
            self._declared(each) for each in statements if isinstance(each, FunctionDefinition | ModuleDefinition)
        ]
        constants = []
        for name, assignment in assigned(statements).items():
            value = self.code(assignment.value)
            unique = self.bind(name, value.kind, value.number, value.string)
            constants.append((assignment.comments, f"(define {unique} {value.text})"))
        for each in functions:
            if isinstance(each.definition, FunctionDefinition) and self.scope.functions[each.definition.name] is each:
                texts += self._function(each)
        texts += constants
        for each in functions:
            if isinstance(each.definition, ModuleDefinition) and self.scope.modules[each.definition.name] is each:
                texts += self._module(each)
        return texts

    def _declared(self, definition: FunctionDefinition | ModuleDefinition) -> Definition:
        is_module = isinstance(definition, ModuleDefinition)
        name = self.scope.fresh(definition.name, "part" if is_module else "of")
        inner = NameScope(self.scope)
        names = tuple(inner.fresh(each.name, "value") for each in definition.parameters)
        takes_children = is_module and uses_children(definition.body)
        function = Definition(definition, name, names, self.scope, takes_children)
        (self.scope.modules if is_module else self.scope.functions)[definition.name] = function
        return function

    def _function(self, function: Definition) -> list[tuple[tuple[str, ...], str]]:
        definition = function.definition
        assert isinstance(definition, FunctionDefinition)
        if not self.c.facts.holds("called", function.place):
            return []
        inner = self.inside()
        inner.owner = function.place
        parameters = inner.parameters(function, self)
        body = inner.code(definition.body)
        self.c.facts.join(function.place, "result", body.kind)
        head = f"{function.name} {parameters}".strip()
        return [(definition.comments, f"(define ({head}) {body.text})")]

    def _module(self, function: Definition) -> list[tuple[tuple[str, ...], str]]:
        variants = [each for each in self.c.facts.all("called", function.place) if isinstance(each, int)]
        return [self._variant(function, each, index) for index, each in enumerate(variants)]

    def _variant(self, function: Definition, variant: int, index: int) -> tuple[tuple[str, ...], str]:
        """Return the comments and the definition of a module for children of ``variant`` dimensions."""
        definition, facts = function.definition, self.c.facts
        assert isinstance(definition, ModuleDefinition)
        inner = self.inside()
        inner.owner, inner.variant, inner.color = function.place, variant, ""
        parameters = [inner.parameters(function, self)]
        inner.children_name = inner.scope.fresh("children", "here")
        inner.specials["$children"] = Snippet(call("length", inner.children_name), INT)
        if function.takes_children:
            parameters.insert(0, inner.children_name)
        for name in facts.all("dynamic", function.place):
            default = self.specials[str(name)]
            own = own_name(str(name))
            inner.specials[str(name)] = Snippet(own, ANY)
            parameters.append(f"(:{own} {default.text})")
        definitions, shapes = inner.block(definition.body)
        shape = inner.united(shapes, definition.span)
        if shape.dimensions:
            facts.mark("dimensions", function.place, variant, shape.dimensions)
        if shape.may_be_empty:
            facts.mark("empty", function.place, variant)
        head = " ".join((self.name_of(function, variant), *(text for text in parameters if text)))
        body = "\n".join((*(with_comments(*each) for each in definitions), inner.commented(shape)))
        return definition.comments if not index else (), f"(define ({head})\n{body})"

    def name_of(self, function: Definition, variant: int) -> str:
        """Return the name of a module for children of ``variant`` dimensions."""
        both = len([each for each in self.c.facts.all("called", function.place) if each]) > 1
        return f"{function.name}-flat" if both and variant == 2 else function.name

    def block(self, statements: Sequence[Statement]) -> tuple[list[tuple[tuple[str, ...], str]], list[Shape]]:
        """Convert the statements of a scope: the texts of its definitions, and its objects."""
        definitions = self.declare(statements)
        checks = [each for each in statements if isinstance(each, Instance) and each.is_check and not each.children]
        definitions += [(each.comments, text) for each in checks if (text := self._assertion(each))]
        shapes = [self.shape(each) for each in statements if isinstance(each, Instance | Branch)]
        return definitions, [shape for shape in shapes if shape is not NOTHING]

    def scoped(self, statements: Sequence[Statement], span: Span) -> Shape:
        """Return the union of statements with a scope of their own."""
        inner = self.inside()
        definitions, shapes = inner.block(statements)
        shape = inner.united(shapes, span)
        if not definitions:
            return shape
        body = "\n".join((*(text for _, text in definitions), inner.place(shape)))
        return shape._replace(text=f"(let ()\n{body})", moves=(), is_list=False)

    # --- statements --------------------------------------------------------------------------------------------------

    def united(self, shapes: Sequence[Shape], span: Span) -> Shape:
        """Return the union of objects."""
        if not shapes:
            return NOTHING
        dimensions = dimensions_of(shapes, span)
        shapes = [shape for shape in shapes if not shape.is_void] or shapes[:1]
        if len(shapes) == 1:
            return shapes[0]
        is_empty = all(shape.may_be_empty for shape in shapes)
        if dimensions == 2:
            may = any(shape.may_be_empty for shape in shapes)
            name = self.c.helper("profiles-union") if may else "profile-union"
            return Shape(long_call(name, list(map(self.place, shapes))), 2, is_empty)
        texts = [with_comments(shape.comments, self.place(shape)) for shape in shapes]
        return Shape("(union\n" + "\n".join(texts) + ")", dimensions, is_empty)

    def shape(self, statement: Instance | Branch) -> Shape:
        """Convert a statement that makes an object."""
        if "*" in statement.modifiers or "%" in statement.modifiers:
            sign = "*" if "*" in statement.modifiers else "%"
            self.c.warn(statement.span, f"objects marked `{sign}` are left out")
            return NOTHING
        if "!" in statement.modifiers:
            unsupported(statement.span, "`!` inside of other objects", "write it in front of a statement of the file")
        made = self._branch(statement) if isinstance(statement, Branch) else self._instance(statement)
        return made._replace(comments=statement.comments) if statement.comments and made is not NOTHING else made

    def _branch(self, branch: Branch) -> Shape:
        test = self.condition(branch.test)
        if test in ("#t", "#f"):
            return self.scoped(branch.yes if test == "#t" else branch.no, branch.span)
        yes, no = self.scoped(branch.yes, branch.span), self.scoped(branch.no, branch.span)
        dimensions = dimensions_of([yes, no], branch.span)
        nothing = "(list)" if dimensions == 2 else "(union)"
        texts = [nothing if each is NOTHING else self.place(each) for each in (yes, no)]
        return Shape(call("if", test, *texts), dimensions, yes.may_be_empty or no.may_be_empty)

    def _instance(self, instance: Instance) -> Shape:
        """Convert a call of a built-in module or of one that the file defines."""
        name = instance.name
        if name in ("echo", "assert"):
            shape = self.scoped(instance.children, instance.span)
            check = self._assertion(instance) if instance.is_check and instance.children else ""
            if not check:
                return shape
            return shape._replace(text=f"(begin {check}\n{self.place(shape)})", moves=(), is_list=False)
        function = self.scope.module(name)
        inner = self.inside()
        # special variables have dynamic scope: the module and its children see these values
        for each in instance.arguments:
            if each.name and each.name.startswith("$"):
                inner.specials[each.name] = self.code(each.value)
        if function is not None:
            return inner.module_call(instance, function)
        if name == "children":
            return inner.children(instance)
        if name in ("for", "intersection_for"):
            return inner.loop(instance)
        if name in _GROUPS:
            return inner.group(instance)
        if name in _BOOLEANS:
            return inner.boolean(instance)
        handler = _MODULES.get(name)
        if handler is None:
            self._unknown(instance)
        return handler(inner, instance)

    def _assertion(self, instance: Instance) -> str:
        """Return the test of `assert`; empty if it certainly holds, or uses what cannot be converted."""
        try:
            given = self.named(instance, ("condition", "message"))
            test = self.truth(given.get("condition", constant(0)))
        except SceneError as found:
            self.c.warn(instance.span, f"this assertion is not tested: {found.message}")
            return ""
        message = [given["message"].text] if "message" in given else []
        return "" if test == "#t" else call("assert", test, *message)

    def _unknown(self, instance: Instance) -> NoReturn:
        span, name = instance.span, instance.name
        known = [*_MODULES, *_BOOLEANS, *_GROUPS, "for", "children"]
        scope: NameScope | None = self.scope
        while scope is not None:
            known += scope.modules
            scope = scope.parent
        near = suggest(name, known)
        failure(span, f"the module `{name}` is not defined", f"did you mean `{near}`?" if near else None)

    def group(self, instance: Instance) -> Shape:
        if instance.name not in ("assign", "let"):
            return self.scoped(instance.children, instance.span)
        texts = []
        for each in instance.arguments:
            value = self.code(each.value)
            texts.append(f"({self.bind(str(each.name), value.kind, value.number)} {value.text})")
        shape = self.scoped(instance.children, instance.span)
        return shape._replace(text=f"(let* ({' '.join(texts)}) {self.place(shape)})", moves=(), is_list=False)

    def loop(self, instance: Instance) -> Shape:
        """Convert `for` and `intersection_for`."""
        self_place, clauses, count = self.clauses([each for each in instance.arguments if each.name])
        name = "for*" if count > 1 else "for"
        if instance.name == "intersection_for":
            self_place.color = ""
        definitions, shapes = self_place.block(instance.children)
        shape = self_place.united(shapes, instance.span)
        if shape is NOTHING:
            return NOTHING
        body = "\n".join((*(with_comments(*each) for each in definitions), self_place.place(shape)))
        may_be_empty = shape.may_be_empty or not all(runs(each) for each in instance.arguments)
        if instance.name == "intersection_for":
            operation = "profile-intersection" if shape.dimensions == 2 else "intersection"
            return Shape(call("apply", operation, f"({name}/list ({clauses})\n{body})"), shape.dimensions, True)
        if shape.dimensions == 2:
            return Shape(f"({name}/list ({clauses})\n{body})", 2, may_be_empty, is_list=True)
        return Shape(f"({name}/union ({clauses})\n{body})", shape.dimensions, may_be_empty)

    def _members(self, instance: Instance) -> tuple[list[str], list[Shape]]:
        """Return the definitions of a boolean's scope, and its operands."""
        definitions, shapes = self.block(instance.children)
        return [text for _, text in definitions], shapes

    def boolean(self, instance: Instance) -> Shape:
        """Convert an operation on several objects, whose color is that of the place."""
        color, self.color = self.color, ""
        definitions, shapes = self._members(instance)
        if not shapes:
            return NOTHING
        name, dimensions = instance.name, dimensions_of(shapes, instance.span)
        if len(shapes) == 1 and name != "hull":
            made = shapes[0]
            if color and dimensions != 2:
                made = self._painted(made, color)
        else:
            texts = [self.place(shape) for shape in shapes]
            made = self._combined(name, dimensions, texts, shapes, color)
        if definitions:
            body = "\n".join((*definitions, self.place(made)))
            made = made._replace(text=f"(let ()\n{body})", moves=(), is_list=False)
        return made

    def _combined(self, name: str, dimensions: int, texts: list[str], shapes: list[Shape], color: str) -> Shape:
        look = [color] if color and dimensions != 2 else []
        if any(shape.may_be_empty for shape in shapes) and dimensions:
            empty = [shape.may_be_empty for shape in shapes]
            may = empty[0] if name == "difference" else any(empty) if name == "intersection" else all(empty)
            text = long_call(self.c.helper(_SAFE[name, dimensions]), texts)
            made = Shape(text, dimensions, may)
            return self._painted(made, color) if look else made
        operation = _FLAT[name] if dimensions == 2 else name
        if name == "minkowski":
            text = texts[0]
            for each in texts[1:]:
                text = call(operation, text, each, *look)
            return Shape(text, dimensions)
        return Shape(long_call(operation, [*texts, *look]), dimensions)

    def _painted(self, shape: Shape, color: str) -> Shape:
        """Return a solid that was made elsewhere with one color."""
        name = self.c.helper("painted") if shape.may_be_empty else "solid-union"
        return Shape(
            call(name, shape._replace(moves=()).text, color), shape.dimensions, shape.may_be_empty, shape.moves
        )

    # --- modules of the program --------------------------------------------------------------------------------------

    def module_call(self, instance: Instance, function: Definition) -> Shape:
        """Convert the call of a module that the program defines."""
        facts, place = self.c.facts, function.place
        definition = function.definition
        texts = self.operands(function, definition.parameters, instance.arguments, instance.span)
        texts += self._handed_down(function, instance)
        color, self.color = self.color, ""
        self._set_for_children(definition)
        variant = 0
        if function.takes_children:
            definitions, shapes = self._members(instance)
            if definitions:
                unsupported(
                    instance.span, "assignments or tests among the children of a module", "move them out of the braces"
                )
            variant = dimensions_of(shapes, instance.span) or (3 if not shapes or facts.holds("assumed") else 0)
            if not shapes or any(shape.may_be_empty for shape in shapes):
                facts.mark("empty-children", place)
            texts.insert(0, call("list", *map(self.place, shapes)))
        if variant == 0 and function.takes_children:
            self.c.is_waiting = True
        else:
            facts.mark("called", place, variant)
        known = facts.all("dimensions", place, variant)
        if len(known) > 1:
            unsupported(definition.span, f"the module `{definition.name}` makes flat and solid objects")
        dimensions = known[0] if known else 0
        assert isinstance(dimensions, int)
        made = Shape(call(self.name_of(function, variant), *texts), dimensions, facts.holds("empty", place, variant))
        return self._painted(made, color) if color and dimensions == 3 else made

    def _set_for_children(self, definition: FunctionDefinition | ModuleDefinition) -> None:
        """Give the children of a call the special variables that the module sets itself."""
        assert isinstance(definition, ModuleDefinition)
        for name, each in assigned(definition.body).items():
            if name.startswith("$") and isinstance(each.value, ConstantValue):
                self.specials[name] = self.code(each.value)
            elif name.startswith("$"):
                self.c.warn(each.span, f"the children of `{definition.name}` do not see its `{name}`")

    def _handed_down(self, function: Definition, instance: Instance) -> list[str]:
        """Return the special variables that a module must get, because they differ from those of the file."""
        facts, texts = self.c.facts, []
        for name in map(str, facts.all("uses", function.place)):
            outside = function.scope.variables.get(name)
            value = self.specials.get(name)
            root: NameScope = function.scope
            while root.parent is not None:
                root = root.parent
            default = outside or root.variables.get(name)
            if value is None or default is None:
                continue
            self.c.facts.mark("uses", self.owner, name)
            if value.text != default.text:
                facts.mark("dynamic", function.place, name)
                texts.append(f":{own_name(name)} {value.text}")
        return texts

    def children(self, instance: Instance) -> Shape:
        """Convert `children()`, `children(i)` and `children([i, j])`."""
        facts = self.c.facts
        if self.owner < 0 or not self.children_name:
            unsupported(instance.span, "`children` outside of a module")
        name, variant = self.children_name, self.variant
        dimensions = variant or 3
        color, self.color = self.color, ""
        may_be_empty = facts.holds("empty-children", self.owner)
        if not instance.arguments:
            made = Shape(name, 2, may_be_empty, is_list=True) if dimensions == 2 else Shape(
                call("union", name), 3, may_be_empty
            )  # fmt: skip
        else:
            index = self.code(instance.arguments[0].value)
            if is_number(index.kind) or index.kind in (ANY, UNKNOWN):
                place = index.text if index.kind == INT else call("floor", index.text)
                made = Shape(call("ref", name, place), dimensions, may_be_empty)
            else:
                chosen = f"(for/list ((number {index.text})) (ref {name} number))"
                made = (
                    Shape(chosen, 2, True, is_list=True) if dimensions == 2 else Shape(call("union", chosen), 3, True)
                )
        return self._painted(made, color) if color and dimensions == 3 else made

    # --- arguments ---------------------------------------------------------------------------------------------------

    def named(self, instance: Instance, names: Sequence[str]) -> dict[str, Snippet]:
        """Return the arguments of a module of OpenSCAD by name; undefined ones are left out."""
        by_name: dict[str, Snippet] = {}
        position = 0
        for each in instance.arguments:
            if each.name is None:
                if position < len(names):
                    by_name[names[position]] = self.code(each.value)
                position += 1
            elif not each.name.startswith("$"):
                by_name[each.name] = self.code(each.value)
        return {name: value for name, value in by_name.items() if value.text != "none"}

    def fragments(self, radius: Snippet) -> str:
        """Return the number of sides of a circle by `$fn`, `$fa` and `$fs`, as OpenSCAD computes it."""
        fn, fa, fs = (self.special(name) for name in ("$fn", "$fa", "$fs"))
        if fn.number is not None and fn.number > 0:
            if 3 <= fn.number <= MAX_SEGMENTS and fn.number == int(fn.number):
                return fn.text
            return str(int(min(max(3, fn.number), MAX_SEGMENTS)))
        literal = [
            each.number
            for each in (radius, fa, fs)
            if each.number is not None and each.text == number_text(each.number)
        ]
        if len(literal) == 3 and fn.number is not None:
            size, angle, length = literal
            return str(fragments_of(size, angle, length))
        return call(self.c.helper("fragments"), radius.text, *self.resolution())

    def resolution(self) -> list[str]:
        """Return `$fn`, `$fa` and `$fs` as keywords, those that are not the default."""
        texts = []
        for name, default in (("fn", "0"), ("fa", "12"), ("fs", "2")):
            value = self.special(f"${name}")
            is_small = name != "fn" and value.number is not None and value.number < LEAST_RESOLUTION
            text = number_text(LEAST_RESOLUTION) if is_small else value.text
            texts += [f":{name} {text}"] if text != default else []
        return texts

    def solid(self, *words: str, may_be_empty: bool = False) -> Shape:
        """Return a call that makes a solid, in the color of the place."""
        return Shape(call(*words, *([self.color] if self.color else [])), 3, may_be_empty)

    def flat(self, *words: str) -> Shape:
        """Return a call that makes a profile."""
        return Shape(call(*words), 2)

    def child(self, instance: Instance) -> Shape:
        """Return the union of the children."""
        return self.scoped(instance.children, instance.span)

    def triple(self, value: Snippet, filler: str) -> str:
        """Return a vector of three numbers."""
        value = self.array(value)
        if value.parts is not None and value.kind.name == "vec":
            return f"[{' '.join([part.text for part in value.parts[:3]] + [filler] * (3 - len(value.parts)))}]"
        if value.kind.name == "vec" and value.kind.size == 3:
            return value.text
        return call(self.c.helper("triple"), value.text, *([filler] if filler != "0" else []))

    def pair(self, value: Snippet) -> tuple[str, str]:
        """Return two numbers of a vector or number."""
        value = self.array(value)
        if value.parts is not None and len(value.parts) >= 2:
            return value.parts[0].text, value.parts[1].text
        if is_number(value.kind):
            return value.text, value.text
        return call("ref", value.text, "0"), call("ref", value.text, "1")


# --- solids ----------------------------------------------------------------------------------------------------------


Handler = Callable[[Objects, Instance], Shape]


def _centered(place: Objects, value: Snippet | None) -> str | None:
    """Return None for a `center` that is false, "#t" for one that is true, else a test."""
    if value is None or value.text in ("#f", "0"):
        return None
    return "#t" if value.text in ("#t", "1") else place.truth(value)


def _either(place: Objects, center: str | None, centered: Shape, corner: Callable[[], Shape]) -> Shape:
    """Return one of two forms of an object, which may be decided when the program runs."""
    if center is None:
        return corner()
    if center == "#t":
        return centered
    text = call("if", center, place.place(centered), place.place(corner()))
    return Shape(text, centered.dimensions)


def _void(place: Objects, instance: Instance, dimensions: int, sizes: Sequence[Snippet]) -> Shape | None:
    """Return nothing, with a warning, if a size is known and not above 0: OpenSCAD makes nothing of it either."""
    small = [each.number for each in sizes if each.number is not None and each.number <= 0]
    if not small:
        return None
    size = number_text(small[0])
    place.c.warn(instance.span, f"`{instance.name}` with a size of {size} makes nothing, as in OpenSCAD")
    return Shape(_VOIDS[dimensions], dimensions, True)


def _cube(place: Objects, instance: Instance) -> Shape:
    given = place.named(instance, ("size", "center"))
    size = place.array(given.get("size", constant(1)))
    center = _centered(place, given.get("center"))
    scale = place.triple(size, "1") if size.parts is not None else size.text
    sizes = size.parts or (size,)
    void = _void(place, instance, 3, sizes)
    if void is not None:
        return void
    if any(each.number is None for each in sizes):
        return place.solid(place.c.helper("box"), scale, *([] if center is None else [f":center {center}"]))
    centered = place.solid("call", '"cube"', f":scale {scale}")
    return _either(place, center, centered, lambda: _corner_box(place, size, scale))


def _corner_box(place: Objects, size: Snippet, scale: str) -> Shape:
    if place.color:
        parts = size.parts if size.parts is not None and len(size.parts) == 3 else None
        offset = vector_code([Snippet(half(part), NUM) for part in parts]).text if parts else (
            call("*", scale, "[0.5 0.5 0.5]")
        )  # fmt: skip
        return place.solid("call", '"cube"', f":scale {scale}").moved("pose", call("translate", offset))
    return Shape(call(place.c.helper("box"), scale), 3)


def _radius(given: Mapping[str, Snippet], names: Sequence[str], diameters: Sequence[str]) -> Snippet:
    """Return a radius that is given under one of several names."""
    for name in names:
        if name in given:
            return given[name]
    for name in diameters:
        if name in given:
            value = given[name]
            text = half(value)
            return constant(value.number / 2) if value.number is not None and text[0] != "(" else Snippet(text, NUM)
    return constant(1)


def _sphere(place: Objects, instance: Instance) -> Shape:
    given = place.named(instance, ("r",))
    radius = _radius(given, ("r",), ("d",))
    sides = place.fragments(radius)
    return _void(place, instance, 3, [radius]) or place.solid(place.c.helper("ball"), radius.text, sides)


def _cylinder(place: Objects, instance: Instance) -> Shape:
    """Return a cylinder, cone or frustum, with the number of sides that OpenSCAD derives from the larger radius."""
    given = place.named(instance, ("h", "r1", "r2", "center"))
    height = given.get("h", constant(1))
    if "r" in given or ("d" in given and "r1" not in given):
        bottom = top = _radius(given, ("r",), ("d",))
    else:
        bottom, top = _radius(given, ("r1",), ("d1", "d")), _radius(given, ("r2",), ("d2", "d"))
    center = _centered(place, given.get("center"))
    largest = bottom
    if bottom.text != top.text:
        both = bottom.number is not None and top.number is not None
        largest = (
            max(bottom, top, key=lambda each: each.number or 0.0)
            if both
            else Snippet(call("max", bottom.text, top.text), NUM)
        )
    # one of the radii may be 0: a cone
    void = _void(place, instance, 3, [height, largest]) or (
        _void(place, instance, 3, [each for each in (bottom, top) if each.number != 0])
    )
    if void is not None:
        return void
    sides = place.fragments(largest)
    keyword = [] if center is None else [f":center {center}"]
    if bottom.text == top.text:
        return place.solid("extrude", f"(circle {bottom.text} :segments {sides})", height.text, *keyword)
    name = place.c.helper("frustum")
    return place.solid(name, height.text, bottom.text, top.text, sides, *keyword)


def _polyhedron(place: Objects, instance: Instance) -> Shape:
    given = place.named(instance, ("points", "faces", "convexity"))
    faces = given.get("faces", given.get("triangles"))
    if "points" not in given or faces is None:
        failure(instance.span, "`polyhedron` without points or faces")
    return place.solid("mesh", given["points"].text, faces.text)


# --- profiles --------------------------------------------------------------------------------------------------------


def _square(place: Objects, instance: Instance) -> Shape:
    given = place.named(instance, ("size", "center"))
    size = given.get("size", constant(1))
    center = _centered(place, given.get("center"))
    width, height = place.pair(size)
    corner = lambda: Shape(call(place.c.helper("corner-rectangle"), width, height), 2)
    return _void(place, instance, 2, size.parts or (size,)) or (
        _either(place, center, place.flat("rectangle", width, height), corner)
    )


def _circle(place: Objects, instance: Instance) -> Shape:
    radius = _radius(place.named(instance, ("r",)), ("r",), ("d",))
    void = _void(place, instance, 2, [radius])
    return void or place.flat("circle", radius.text, f":segments {place.fragments(radius)}")


def _polygon(place: Objects, instance: Instance) -> Shape:
    given = place.named(instance, ("points", "paths", "convexity"))
    if "points" not in given:
        failure(instance.span, "`polygon` without points")
    points = given["points"]
    if "paths" in given:
        return place.flat(place.c.helper("polygon-paths"), points.text, given["paths"].text)
    if _is_simple(points):
        return place.flat("polygon", points.text)
    return place.flat("profile-union", f"(polygon {points.text})", ":fill :even-odd")


def _is_simple(points: Snippet) -> bool:
    """Return whether the points of a polygon are written out and form a contour that does not cross itself."""
    from scenelang.interpreter.scene.modelling.contours import crossing_of

    corners = [[number.number for number in point.parts or ()] for point in points.parts or ()]
    if len(corners) < 3 or any(len(point) != 2 or None in point for point in corners):
        return False
    return crossing_of(np.array(corners, np.float64)) is None


_TEXT = ("text", "size", "font", "halign", "valign", "spacing", "direction", "language", "script")


def _text(place: Objects, instance: Instance) -> Shape:
    """Return the outline of a text in the bundled font; warn of other fonts and of options without a counterpart."""
    given = place.named(instance, _TEXT)
    if "text" not in given:
        return NOTHING
    font = given.get("font")
    if font is None or "dejavu sans" not in font.text.lower():
        place.c.warn(instance.span, "`text` is drawn in DejaVu Sans, the bundled font", "give `:font` a font's file")
    if "direction" in given or "spacing" in given:
        place.c.warn(instance.span, "`direction` and `spacing` of `text` are ignored")
    size = given.get("size", constant(10))
    literal = size.number is not None and size.text == number_text(size.number)
    # OpenSCAD renders `size` points at 100 dpi, and a point is 1/72 of an inch
    em = (
        number_text(round(size.number * 100 / 72, 6))
        if literal and size.number is not None
        else f"(* {size.text} {100 / 72:.6f})"
    )
    words = ["text-outline", given["text"].text, f":size {em}"]
    align = given.get("halign")
    if align is not None and align.text != '"left"':
        if align.text not in ('"center"', '"right"'):
            unsupported(instance.span, "`halign` that is not written out")
        words.append(f":align :{align.text[1:-1]}")
    valign = given.get("valign")
    if valign is None or valign.text == '"baseline"':
        return place.flat(*words)
    return place.flat(place.c.helper("raised-text"), call(*words), valign.text)


# --- from profiles to solids -----------------------------------------------------------------------------------------


def _projection(place: Objects, instance: Instance) -> Shape:
    given = place.named(instance, ("cut",))
    color, place.color = place.color, ""
    shape = place.child(instance)
    place.color = color
    if shape.dimensions == 2:
        unsupported(instance.span, "`projection` of a flat object")
    if shape is NOTHING:
        return NOTHING
    cut = given.get("cut", constant(0))
    if cut.text not in ("#t", "#f", "0", "1"):
        unsupported(instance.span, "`cut` that is not written out")
    name = "profile-section" if cut.text in ("#t", "1") else "profile-silhouette"
    if shape.may_be_empty:
        text = f"({place.c.helper('if-solid')} {place.place(shape)} {name})"
    else:
        text = call(name, place.place(shape))
    return Shape(text, 2, shape.may_be_empty or name == "profile-section")


def _profile(place: Objects, instance: Instance) -> tuple[Shape, str]:
    """Return the profile of an extrusion, and its expression as an operand of the call."""
    color, place.color = place.color, ""
    shape = place.child(instance)
    place.color = color
    if shape.dimensions == 3:
        unsupported(instance.span, f"`{instance.name}` of a solid")
    return shape, "profile" if shape.may_be_empty else place.place(shape)


def _from_profile(place: Objects, shape: Shape, made: Shape) -> Shape:
    """Return a solid, or nothing if its profile is empty."""
    if shape is NOTHING:
        return NOTHING
    if shape.is_void:
        return Shape(_VOIDS[3], 3, True)
    if not shape.may_be_empty:
        return made
    helper = place.c.helper("if-profile")
    return Shape(call(helper, place.place(shape), f"(lambda (profile) {made.text})"), 3, True, made.moves)


_EXTRUDE = ("height", "center", "convexity", "twist", "slices", "scale")


def _linear_extrude(place: Objects, instance: Instance) -> Shape:
    given = place.named(instance, _EXTRUDE)
    shape, profile = _profile(place, instance)
    height = given.get("height", constant(100))
    void = _void(place, instance, 3, [height])
    if void is not None:
        return void
    words, name = [profile, height.text], "extrude"
    twist, taper = given.get("twist"), given.get("scale")
    slices = _slices(place, given, twist)
    if twist is not None and twist.number != 0 and taper is not None and taper.number is None:
        # OpenSCAD scales after it has turned, along axes that stand still
        unsupported(instance.span, "`twist` with a `scale` of two numbers", "use one number for `scale`")
    if twist is not None and twist.number != 0:
        if slices is None:
            name = place.c.helper("twisted")
            words += [twist.text, *place.resolution()]
        else:
            words.append(f":twist {call('deg', place.negative(twist).text)}")
    if slices is not None:
        words.append(f":slices {slices}")
    if taper is not None:
        words.append(f":taper {taper.text}")
    center = _centered(place, given.get("center"))
    if center is not None:
        words.append(f":center {center}")
    return _from_profile(place, shape, place.solid(name, *words))


def _slices(place: Objects, given: Mapping[str, Snippet], twist: Snippet | None) -> str | None:
    """Return the number of layers of a twist by OpenSCAD's rules; None if it is not known here."""
    if "slices" in given:
        return given["slices"].text
    fn = place.special("$fn")
    if twist is not None and fn.number is not None and fn.number > 0 and twist.number is not None:
        return str(max(1, math.ceil(abs(twist.number) / 120), math.ceil(abs(twist.number) / 360 * fn.number)))
    return None


def _rotate_extrude(place: Objects, instance: Instance) -> Shape:
    given = place.named(instance, ("angle", "convexity"))
    shape, profile = _profile(place, instance)
    if "angle" in given and given["angle"].number == 0:
        return _void(place, instance, 3, [given["angle"]]) or NOTHING
    words = [f":angle {given['angle'].text}"] if "angle" in given else []
    return _from_profile(place, shape, place.solid(place.c.helper("turned"), profile, *words, *place.resolution()))


def _offset(place: Objects, instance: Instance) -> Shape:
    given = place.named(instance, ("r", "delta", "chamfer"))
    shape, profile = _profile(place, instance)
    if shape is NOTHING:
        return NOTHING
    name, distance = "offset-profile", given.get("delta", given.get("r", constant(1)))
    if "delta" in given:
        join = ":square" if given.get("chamfer", constant(0)).text == "#t" else ":miter :limit 1000"
        words = [profile, distance.text, f":join {join}"]
    else:
        size = (
            constant(abs(distance.number)) if distance.number is not None else Snippet(call("abs", distance.text), NUM)
        )
        sides = place.fragments(size)
        words = [profile, distance.text, f":segments {sides}"]
        if not sides.isdigit() or int(sides) < _FINE:  # the corners of OpenSCAD show
            name, words = place.c.helper("round-offset"), [profile, distance.text, sides]
    text = call(name, *words)
    if shape.may_be_empty:
        text = call(place.c.helper("map-profile"), place.place(shape), f"(lambda (profile) {text})")
    grows = distance.number is not None and distance.number > 0
    return Shape(text, 2, shape.may_be_empty or not grows)


# --- movements -------------------------------------------------------------------------------------------------------


def _moving(make: Callable[[Objects, Instance, Shape], Shape]) -> Handler:
    def handler(place: Objects, instance: Instance) -> Shape:
        shape = place.child(instance)
        if shape.is_void:
            return shape
        if shape.is_list:
            shape = Shape(placed(place.c, shape), 2, shape.may_be_empty)
        return make(place, instance, shape)

    return handler


def _argument(place: Objects, instance: Instance, names: Sequence[str]) -> Snippet:
    given = place.named(instance, names)
    if names[0] not in given:
        failure(instance.span, f"`{instance.name}` without `{names[0]}`")
    return given[names[0]]


def _translate(place: Objects, instance: Instance, shape: Shape) -> Shape:
    value = _argument(place, instance, ("v",))
    if shape.dimensions == 2:
        return shape.moved("move", f"[{' '.join(place.pair(value))}]")
    return shape.moved("pose", call("translate", place.triple(value, "0")))


def _radians(place: Objects, angle: Snippet) -> str:
    return call("deg", angle.text)


def _rotate(place: Objects, instance: Instance, shape: Shape) -> Shape:
    """Return a shape rotated about an axis, or about the axes x, y and z in turn."""
    given = place.named(instance, ("a", "v"))
    angle = given.get("a", constant(0))
    if shape.dimensions == 2:
        if angle.parts is not None and angle.kind.name == "vec":
            angle = angle.parts[2] if len(angle.parts) > 2 else constant(0)
        elif not is_number(angle.kind) and angle.kind.name == "vec":
            angle = Snippet(call("ref", angle.text, "2"), NUM)
        return shape.moved("rotate", _radians(place, angle))
    axis_code = given.get("v")
    # OpenSCAD does not rotate about a zero vector; `turn` tests for one when the program runs
    is_fixed = axis_code is None or (axis_code.parts is not None and any(part.number for part in axis_code.parts))
    if is_number(angle.kind) and is_fixed:
        axis = place.triple(given["v"], "0") if "v" in given else "[0 0 1]"
        return shape.moved("pose", call("rotate", _radians(place, angle), axis))
    if is_number(angle.kind) or angle.parts is None or angle.kind.name != "vec":
        helper = place.c.helper("turn")
        axis_texts = [place.triple(given["v"], "0")] if "v" in given else []
        return shape.moved("pose", call(helper, angle.text, *axis_texts))
    for part, axis in zip(angle.parts, ("[1 0 0]", "[0 1 0]", "[0 0 1]"), strict=False):
        if part.number != 0 or part.text != "0":
            shape = shape.moved("pose", call("rotate", _radians(place, part), axis))
    return shape


def _scale(place: Objects, instance: Instance, shape: Shape) -> Shape:
    value = _argument(place, instance, ("v",))
    if shape.dimensions == 2:
        return shape.moved("scale", value.text if is_number(value.kind) else f"[{' '.join(place.pair(value))}]")
    text = value.text if is_number(value.kind) else place.triple(value, "1")
    return shape.moved("pose", call("scale", text))


def _mirror(place: Objects, instance: Instance, shape: Shape) -> Shape:
    value = _argument(place, instance, ("v",))
    if value.parts is not None and all(part.number == 0 for part in value.parts):
        return shape
    if shape.dimensions != 2:
        return shape.moved("pose", call("reflect", place.triple(value, "0")))
    x, y = place.pair(value)
    if y == "0":
        return shape.moved("scale", "[-1 1]")
    if x == "0":
        return shape.moved("scale", "[1 -1]")
    return shape.moved("scale", "[-1 1]").moved("rotate", f"(* 2 (atan {y} {x}))")


def _multmatrix(place: Objects, instance: Instance, shape: Shape) -> Shape:
    value = _argument(place, instance, ("m",))
    if shape.dimensions == 2:
        return shape.moved("matrix", value.text)
    if value.parts is not None and len(value.parts) == 4:
        rows = value.parts
        return shape.moved("pose", value.text if value.kind.name == "mat" else call("array", _rows(rows)))
    return shape.moved("pose", call(place.c.helper("full-matrix"), value.text))


def _rows(rows: Sequence[Snippet]) -> str:
    return call("list", *(row.text for row in rows))


def _resize(place: Objects, instance: Instance, shape: Shape) -> Shape:
    given = place.named(instance, ("newsize", "auto"))
    if shape.dimensions == 2:
        unsupported(instance.span, "`resize` of flat objects", "use `scale`")
    if "auto" in given and given["auto"].text != "#f":
        unsupported(instance.span, "`resize` with `auto`", "write all three sizes")
    text = call(place.c.helper("resized"), placed(place.c, shape), place.triple(given.get("newsize", constant(0)), "0"))
    return Shape(text, 3, shape.may_be_empty)


def _color(place: Objects, instance: Instance) -> Shape:
    given = place.named(instance, ("c", "alpha"))
    if not place.color and "c" in given:
        place.color = look_of(place.c, given["c"], given.get("alpha"), instance.span)
    return place.child(instance)


_MODULES: dict[str, Handler] = {
    "cube": _cube, "sphere": _sphere, "cylinder": _cylinder, "polyhedron": _polyhedron, "square": _square,
    "circle": _circle, "polygon": _polygon, "text": _text, "linear_extrude": _linear_extrude,
    "rotate_extrude": _rotate_extrude, "projection": _projection, "offset": _offset, "color": _color,
    "translate": _moving(_translate), "rotate": _moving(_rotate), "scale": _moving(_scale), "mirror": _moving(_mirror),
    "multmatrix": _moving(_multmatrix), "resize": _moving(_resize),
}  # fmt: skip
