"""Solids, profiles, paths and declarations of Python mode: each function of the registries, each relation.

The calls are made from the registries, so that a new builtin or relation is tested as well. What they translate to is
compared with the form that the same arguments make in the language.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pytest

import scenelang as sl
from scenelang.grammar.datum import Atom, Datum, Keyword, ListDatum, Source, print_datum, walk
from scenelang.grammar.diagnostics import Diagnostic
from scenelang.grammar.python_helpers import HELPERS
from scenelang.grammar.reader import read
from scenelang.interpreter.runtime import modelling_signatures
from scenelang.interpreter.runtime.modelling_helpers import (
    ModellingHelper,
    RelationHelper,
    modelling_helpers,
    part_helpers,
    relation_helpers,
)
from scenelang.interpreter.scene.declarations import FLAGS, SCENES, Relation, example_of
from scenelang.interpreter.transpile.analysis.scopes import BUILTINS as PYTHON_BUILTINS
from scenelang.session.session import Session
from scenelang.stdlib.reference import modelling_text
from transpile.cases import first_difference, flattened

SESSION = Session()
MODELLING, RELATIONS = modelling_helpers(), relation_helpers()
HEAD = "from helper import *\n\n"
BALL = ("primitive_call('sphere', {'radius': .6})", '(call "sphere" :radius .6)')
BOX = ("primitive_call('cube')", '(call "cube")')
SQUARE = ("rectangle(1, 2)", "(rectangle 1 2)")
LINE = ("[(0, 0, 0), (1, 0, 0), (2, 1, 0)]", "'((0 0 0) (1 0 0) (2 1 0))")
NO = ("False", "#f")
CORNERS = ("[(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]", "'((0 0 0) (1 0 0) (0 1 0) (0 0 1))")
FACES = ("[(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]", "'((0 2 1) (0 1 3) (1 2 3) (0 3 2))")
HEIGHTS = ("lambda x, z: x * z + 1", "(lambda (x z) (+ (* x z) 1))")
# What a parameter may be in Python and in the language, by its name; by the function, too, where one name means two.
VALUES: Mapping[str, tuple[str, str]] = {
    "base": BOX, "tools": BALL, "first": BOX, "others": BALL, "tool": BALL, "solid": BOX, "x": BOX, "profile": SQUARE,
    "radius": (".25", ".25"), "thickness": (".1", ".1"), "distance": (".1", ".1"), "normal": ("(0, 1, 0)", "[0 1 0]"),
    "point": ("(0, .1, 0)", "[0 .1 0]"), "z": (".1", ".1"), "height": ("2", "2"), "width": ("1", "1"), "path": LINE,
    "profiles": ("[rectangle(1, 2), circle(1)]", "(list (rectangle 1 2) (circle 1))"), "heights": HEIGHTS,
    "vertices": CORNERS, "faces": FACES, "count": ("3", "3"), "points": ("[(0, 0), (1, 0), (1, 2)]", "'((0 0) (1 0) (1 2))"),
    "text": ("'Ada'", '"Ada"'), "sides": ("5", "5"), "outer": ("2", "2"), "inner": ("1", "1"), "start": ("0", "0"),
    "end": ("1", "1"), "data": ("'M0 0 H4 V-2 H0 Z'", '"M0 0 H4 V-2 H0 Z"'), "turns": ("2", "2"), "t": (".5", ".5"),
    "segments": ("8", "8"), "color": ("(1, 0, 0)", "[1 0 0]"), "opacity": (".5", ".5"), "metallic": ("1", "1"),
    "roughness": (".4", ".4"), "emission": ("(1, 1, 0)", "[1 1 0]"), "ior": ("1.5", "1.5"),
    "coat": (".5", ".5"), "sheen": (".5", ".5"), "material": ("'oak'", '"oak"'), "texture": ("'brick'", '"brick"'),
    "twist": (".5", ".5"),
    "taper": (".5", ".5"), "slices": ("4", "4"), "center": ("True", "#t"), "fill": ("'nonzero'", ":nonzero"),
    "depth": (".3", ".3"), "size": ("2", "2"), "align": ("'center'", ":center"), "spacing": (".1", ".1"),
    "line-height": ("1.1", "1.1"), "angle": ("3", "3"), "closed": ("True", "#t"), "upright": ("True", "#t"),
    "chained": NO, "tolerance": (".1", ".1"), "join": ("'miter'", ":miter"), "limit": ("3", "3"),
    "move": ("(1, 2)", "[1 2]"), "rotate": (".5", ".5"), "scale": ("(2, 1)", "[2 1]"),
    "poses": ("[translation_matrix((0, 0, 0)), translation_matrix((0, 0, 2))]",
              "(list (translate [0 0 0]) (translate [0 0 2]))"),
    "regular-polygon radius": ("2", "2"), "star points": ("5", "5"), "loft heights": ("(0, 3)", "[0 3]"),
    "text-outline text": ("'io'", '"io"'), "heightfield base": ("-30", "-30"), "heightfield segments": ("4", "4"),
    **{f"profile-{name} {key}": SQUARE for name in ("union", "difference", "intersection", "hull", "minkowski")
       for key in ("first", "base")},
    **{f"profile-{name} {key}": ("circle(.5)", "(circle .5)")
       for name in ("union", "difference", "intersection", "hull", "minkowski") for key in ("others", "tools", "tool")},
}  # fmt: skip
NEEDS_A_FILE_OR_STREAM = ("font", "stream")
CASES = [
    (helper, keyword)
    for helper in MODELLING.values()
    for keyword in (None, *(p.name for p in helper.signature.keywords if p.name not in NEEDS_A_FILE_OR_STREAM))
]


def value(helper: ModellingHelper, name: str) -> tuple[str, str]:
    return VALUES.get(f"{helper.counterpart} {name}", VALUES.get(name, ("", "")))


def scene_of(body: str, before: str = "") -> Source:
    return Source("a.py", f"{HEAD}{before}\n\n@register()\ndef scene() -> Shape:\n    {body}\n")


def forms(text: str) -> list[Datum]:
    return list(walk(*read(Source("a.scene", text)).forms))


def has_form(text: str, form: str) -> bool:
    """Whether a program has a form, whatever its layout."""
    (wanted,) = read(Source("form.scene", form)).forms
    return print_datum(wanted) in {print_datum(datum) for datum in forms(text)}


def translated(source: Source) -> str:
    result = SESSION.transpile(source, literal=True)
    assert [d.message for d in result.diagnostics] == []
    return result.text


def errors(source: Source) -> list[Diagnostic]:
    return [d for d in SESSION.transpile(source).diagnostics if d.is_error]


# --- solids, profiles and paths --------------------------------------------------------------------------------------


@pytest.mark.parametrize(("helper", "keyword"), CASES, ids=lambda each: getattr(each, "name", each))
@pytest.mark.sampled(3)
def test_a_call_becomes_the_form_of_the_language(helper: ModellingHelper, keyword: str | None) -> None:
    rest = [helper.signature.rest.name] if helper.signature.rest else []
    names = [parameter.name for parameter in helper.signature.positional] + rest
    python, lisp = zip(*(value(helper, name) for name in names))
    options = [] if keyword is None else [f"{keyword.replace('-', '_')}={value(helper, keyword)[0]}"]
    call = f"{helper.name}({', '.join([*python, *options])})"
    body = f"return {call}" if helper.is_shape else f"print({call})\n    return primitive_call('cube')"
    text = translated(scene_of(body))
    option = "" if keyword is None else f" :{keyword} {value(helper, keyword)[1]}"
    assert has_form(text, f"({helper.counterpart} {' '.join(lisp)}{option})"), text
    checked = SESSION.evaluate(Source("a.scene", text))
    assert checked.ok, [d.message for d in checked.diagnostics]


def test_there_is_a_value_for_each_parameter() -> None:
    names = {p.name for helper in MODELLING.values() for p in helper.signature.parameters}
    assert names - {key.split()[-1] for key in VALUES} == set(NEEDS_A_FILE_OR_STREAM)


def test_the_signatures_are_those_of_the_registry() -> None:
    """After a change of a builtin: ``make tables``."""
    assert Path(modelling_signatures.__file__).read_text("utf-8") == modelling_text()


def test_no_function_has_the_name_of_another() -> None:
    names = [*MODELLING, *part_helpers(), *RELATIONS, *HELPERS]
    assert len(names) == len(set(names))
    assert not set(names) & PYTHON_BUILTINS


def test_parameters_may_be_given_by_name_and_by_star() -> None:
    body = "holes = [primitive_call('sphere'), primitive_call('cone')]\n    return {}"
    named = translated(scene_of("return extrude(height=2, profile=circle(1))"))
    assert has_form(named, "(extrude (circle 1) 2)")
    assert has_form(translated(scene_of(body.format("difference(primitive_call('cube'), *holes)"))), "difference")
    many = SESSION.evaluate(scene_of(
        "holes = [transform_shape(primitive_call('cube', {'scale': (.1, 2, .1)}), translation_matrix((.3 * i, 0, 0)))"
        " for i in range(2)]\n    return difference(primitive_call('cube'), *holes, color=(1, 0, 0))"
    ))  # fmt: skip
    assert many.ok
    assert many.scene is not None


def test_functions_may_be_passed() -> None:
    text = translated(scene_of("return loft(list(map(circle, [1, .5])), heights=(0, 1))"))
    assert has_form(text, "(map circle '(1 .5))"), text


def test_names_of_the_program_win() -> None:
    text = translated(scene_of("return hull(2)", "def hull(n):\n    return loop(n, lambda i: primitive_call('cube'))"))
    assert "(define (hull n)" in text
    local = scene_of("circle = lambda r: 2 * r\n    return extrude(rectangle(1, circle(1)), 1)")
    assert sl.evaluate(local.text, name="a.py").extents[1] == pytest.approx(2)
    hidden = SESSION.evaluate(scene_of("circle = 2\n    return extrude(rectangle(circle, circle), 1)"))
    assert hidden.ok


WRONG = {
    "return extrude(circle(1))": ("extrude(circle(1))", "expects other arguments"),
    "return extrude(circle(1), 1, 2)": ("extrude(circle(1), 1, 2)", "expects other arguments"),
    "return extrude(circle(1), hight=1)": ("hight=1", "no parameter `hight`"),
    "return extrude(circle(1), 1, height=2)": ("height=2", "`height`"),
    "return extrude(circle(1), 1, twist='a')": ("'a'", "twist"),
    "return lathe(polygon(3))": ("polygon(3)", "polygon"),
    "return difference()": ("difference()", "expects other arguments"),
    "return extrude(offset_profile(circle(1), 1, join=str(2)), 1)": ("str(2)", "constant text"),
}


@pytest.mark.parametrize("body", WRONG)
def test_wrong_arguments_are_told_at_their_place(body: str) -> None:
    place, message = WRONG[body]
    source = scene_of(body)
    (problem,) = [d for d in SESSION.check(source).diagnostics if d.is_error] or [
        d for d in SESSION.evaluate(source).diagnostics if d.is_error
    ]
    assert message in problem.message, problem
    assert problem.span is not None
    assert problem.span.text in (place, body.removeprefix("return ")), problem.span.text
    assert problem.code.startswith("E")


# --- declarations ------------------------------------------------------------------------------------------------------

OPTIONS: Mapping[str, tuple[str, str]] = {
    "within": (".1", ".1"), "min": (".1", ".1"), "max": ("9", "9"), "share": (".2", ".2"), "axis": ("'y'", '"y"'),
    "along": ("'x'", '"x"'), "around": ("'table'", '"table"'), "about": ("'table'", '"table"'),
    "across": ("'x'", '"x"'), "each": ("(1, 2)", "'(1 2)"), "to": ("'x'", '"x"'),
}  # fmt: skip


def in_python(helper: RelationHelper, form: Datum) -> str:
    """A declaration as Python writes it."""
    assert isinstance(form, ListDatum)
    written: list[str] = []
    items = iter(form.items[1:])
    for item in items:
        assert isinstance(item, (Atom, ListDatum))
        if isinstance(item, Atom) and isinstance(item.value, Keyword):
            is_flag = str(item.value) in FLAGS
            written.append(f"{item.value}={True if is_flag else literal(next(items))}")
        else:
            written.append(literal(item))
    return f"{helper.name}({', '.join(written)})"


def literal(item: Datum) -> str:
    assert isinstance(item, Atom)
    return repr(item.value)


def declared(body: str, outside: str = "") -> str:
    return translated(scene_of(f"{body}\n    return primitive_call('cube')" if body else "return primitive_call('cube')",
                               outside))  # fmt: skip


@pytest.mark.parametrize("helper", RELATIONS.values(), ids=lambda each: each.name)
def test_the_example_of_a_relation_is_the_same_in_python(helper: RelationHelper) -> None:
    (example,) = read(Source("a.scene", helper.relation.example)).forms
    call = in_python(helper, example)
    for text in (declared(f"assert_that({call})"), declared("", f"assert_that({call})")):
        assert has_form(text, f"(assert-that {helper.relation.example})"), text
    assert has_form(declared(f"assert_that(not {call})"), f"(assert-that (not {helper.relation.example}))")
    assert SCENES[helper.relation.name] in example_of(helper.relation)


@pytest.mark.parametrize("helper", RELATIONS.values(), ids=lambda each: each.name)
@pytest.mark.sampled(3)
def test_each_option_of_a_relation(helper: RelationHelper) -> None:
    words = [f"'{letter}'" for letter in "abc"[: sum(kind == "object" for kind in helper.relation.operands)]]
    least, _ = helper.relation.operand_counts
    more = [VALUES_OF_KINDS[kind] for kind in helper.relation.operands[len(words) : least]]
    for option, key in helper.keywords.items():
        python, lisp = ("True", "") if key in FLAGS else OPTIONS[key]
        call = f"{helper.name}({', '.join([*words, *more, f'{option}={python}'])})"
        operands = " ".join([*words, *more]).replace("'", '"')
        expected = f"({helper.relation.name} {operands} :{key} {lisp})"
        assert has_form(declared(f"assert_that({call})"), f"(assert-that {expected})"), call


VALUES_OF_KINDS = {"number": "2", "color": "'red'", "outline": "'round'", "path": "'line'", "material": "'oak'"}


def test_the_operand_that_is_no_object_may_be_named() -> None:
    for name in ("length", "value"):
        text = declared(f"assert_that(on('cup', 'table'), size('table', axis='y', {name}=.75), 'at hand')")
        assert has_form(text, '(assert-that (on "cup" "table") (size "table" .75 :axis "y") "at hand")'), text


def test_declarations_take_expressions_and_are_joined_by_and() -> None:
    text = declared(
        "n = 2\n    assert_that(count('leg', 2 * n) and supported('leg'), clear_of('leg', 'leg', any=False))"
    )
    assert has_form(text, '(clear-of "leg" "leg")'), text
    assert has_form(text, '(supported "leg")')
    assert "(count " in text


def test_declarations_of_python_are_tested() -> None:
    source = scene_of(
        "assert_that(count('leg', 3))\n    return loop(2, lambda i: library_call('leg'))",
        "@register()\ndef leg() -> Shape:\n    return primitive_call('cube')",
    )
    scene = sl.evaluate(source.text, name="a.py")
    (failed,) = scene.violations()
    assert failed.message == "there are 2"


def test_declarations_stay_where_a_function_is_evaluated() -> None:
    source = scene_of(
        "assert_that(on('cup', 'table'))\n    n = Fraction(6, 3)\n    r = [rounded(primitive_call('cube'), .1)] * int(n)"
        "\n    return concat_shapes(*r)",
        "from fractions import Fraction",
    )
    text = SESSION.transpile(source).text
    assert has_form(text, '(assert-that (on "cup" "table"))'), text
    assert "rounded" in text


WRONG_DECLARATIONS = {
    "assert_that()": ("assert_that()", "expects relations"),
    "assert_that('cup')": ("'cup'", "expects relations"),
    "assert_that(on('cup'))": ("on('cup')", "`on` expects 2 operands, got 1"),
    "assert_that(in_front_of('cup'))": ("in_front_of('cup')", "`in_front_of` expects 2 operands"),
    "assert_that(near('cup', 'a'))": ("near('cup', 'a')", "unknown relation `near`"),
    "assert_that(on('cup', 'table', wihtin=.1))": ("wihtin=.1", "no parameter `wihtin`"),
    "assert_that(on('cup', 'table', value=.1))": ("value=.1", "no operand left"),
    "assert_that(on('cup', 'table'), any=True)": ("any=True", "`assert_that` has no parameter `any`"),
    "on('cup', 'table')": ("on('cup', 'table')", "only `assert_that` takes"),
    "size = 1\n    assert_that(size('cup', axis='y', value=1))": (
        "size('cup', axis='y', value=1)",
        "name of the program",
    ),
}


@pytest.mark.parametrize("body", WRONG_DECLARATIONS)
def test_wrong_declarations_are_told_at_their_place(body: str) -> None:
    place, message = WRONG_DECLARATIONS[body]
    (problem,) = errors(scene_of(f"{body}\n    return primitive_call('cube')"))
    assert message in problem.message, problem
    assert problem.name == "python-call"
    assert problem.span is not None
    assert problem.span.text == place


def test_each_relation_has_names_for_its_operands() -> None:
    def named(relation: Relation) -> int:
        return len(RELATIONS[relation.name.replace("-", "_")].operands)

    assert all(named(helper.relation) == len(helper.relation.operands) for helper in RELATIONS.values())


PART_CALLS = {
    "a part with arguments": ("chair(height=0.95, slats=4, color=(0.2, 0.3, 0.4))", '(call "chair" :height .95 :slats 4 :color [.2 .3 .4])'),
    "a word of two": ("potted_plant()", '(call "potted plant")'),
    "a socket": ("transform_shape(vase(), table_top(height=0.6))", '(transform (call "vase") (table-top :height .6))'),
    "a list of sockets": ("concat_shapes(*[transform_shape(chair(), pose) for pose in table_seats(count=6)])",
        '(for/union ((pose (table-seats :count 6))) (transform (call "chair") pose))'),
    "a socket of what is moved": ("transform_shape(lamp(), translation_matrix((1, 0, 2)) @ desk_top())",
        '(transform (call "lamp") (@ (translate [1 0 2]) (desk-top)))'),
}  # fmt: skip


@pytest.mark.parametrize("name", PART_CALLS)
def test_parts_of_the_library_are_functions(name: str) -> None:
    python, language = PART_CALLS[name]
    translation = SESSION.transpile(
        Source("a.py", f"from helper import *\n\n@register()\ndef room() -> Shape:\n    return {python}\n")
    )
    assert translation.ok, translation.diagnostics
    imports = '(import "std/furniture.scene") (import "std/kitchen.scene") (import "std/garden.scene")'
    expected = SESSION.evaluate(Source("b.scene", f'{imports} (bind "room" (lambda () {language})) (scene "room")'))
    made = SESSION.evaluate(Source("a.scene", translation.text))
    assert first_difference(flattened(made.require()), flattened(expected.require())) is None


def test_every_part_and_socket_is_a_function() -> None:
    calls = [f"{each.name}()" for each in part_helpers().values()]
    body = "\n".join(f"    made.append({call})" for call in calls if part_helpers()[call[:-2]].is_word)
    poses = ", ".join(call for call in calls if not part_helpers()[call[:-2]].is_word)
    code = f"from helper import *\n\n@register()\ndef room() -> Shape:\n    made, poses = [], [{poses}]\n{body}\n    return concat_shapes(*made)\n"
    translation = SESSION.transpile(Source("a.py", code))
    assert translation.ok, translation.diagnostics
    assert len(SESSION.evaluate(Source("a.scene", translation.text)).require().root.children) >= 30


def test_an_own_function_is_no_part() -> None:
    code = (
        "from helper import *\n\ndef chair(size=1.0):\n    return primitive_call('cube', shape_kwargs={'scale': size})\n\n"
        "@register()\ndef room() -> Shape:\n    return chair(size=2)\n"
    )
    translation = SESSION.transpile(Source("a.py", code))
    assert translation.ok
    assert "import" not in translation.text
