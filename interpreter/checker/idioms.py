"""Tables of constructs of other languages, with the code to write instead.

``habits`` matches them against the datums of a program that already has an error, so they cost nothing otherwise and
cannot cause false alarms.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Term:
    """Name of another language. ``instead`` replaces it in place; without it, only the hint is given."""

    language: str
    instead: str = ""
    hint: str = ""


@dataclass(frozen=True, slots=True)
class Idiom:
    """Form of another language, as a pattern of datums: ``?x`` is one datum, ``?x ...`` all that follow.

    ``instead`` is the equivalent form of this language; ``?x/2`` groups the datums in pairs. ``defines`` is the pattern
    variable of the name that the form defines. Some variables only match certain datums (``_SHAPES`` of ``habits``).
    """

    language: str
    pattern: str
    instead: str
    hint: str
    defines: str = ""
    is_sure: bool = True  # whether the replacement means the same in every program


@dataclass(frozen=True, slots=True)
class Spelling:
    """Spelling of a literal, comment or access in another language.

    Attributes
    ----------
    language
        Language, for the message.
    pattern
        Regular expression over the text outside strings.
    instead
        Replacement of a match, a template for ``re.Match.expand``.
    hint
        What to write.
    is_sure
        Whether a match is certainly this construct, so that the replacement is safe.
    """

    language: str
    pattern: str
    instead: str
    hint: str
    is_sure: bool = True


NAMES: Mapping[str, Term] = {
    "True": Term("Python", "#t"), "False": Term("Python", "#f"), "None": Term("Python", "none"),
    "true": Term("JavaScript", "#t"), "false": Term("JavaScript", "#f"), "null": Term("JavaScript", "none"),
    "undefined": Term("JavaScript", "none"), "undef": Term("OpenSCAD", "none"), "nil": Term("Clojure", "none"),
    "NIL": Term("Common Lisp", "none"), "T": Term("Common Lisp", "#t"),
    "math.pi": Term("Python", "pi"), "np.pi": Term("Python", "pi"), "Math.PI": Term("JavaScript", "pi"),
    "PI": Term("OpenSCAD", "pi"), "+inf.0": Term("Scheme", "inf"), "-inf.0": Term("Scheme", "(- inf)"),
    "+nan.0": Term("Scheme", "nan"), "math.inf": Term("Python", "inf"), "math.tau": Term("Python", "tau"),
    "len": Term("Python", "length"), "str": Term("Python", "string"), "ceil": Term("Python", "ceiling"),
    "pow": Term("Python", "expt"), "float": Term("Python", "inexact"), "int": Term("Python", "truncate"),
    "mod": Term("Common Lisp", "%"), "fmod": Term("Python", "%"), "mapcar": Term("Common Lisp", "map"),
    "concat": Term("Clojure", "append"), "extend": Term("Python", "append"),
    "println": Term("Clojure", "print"), "echo": Term("OpenSCAD", "print"),
    "displayln": Term("Scheme", "print"), "vec": Term("Clojure", "list->vector"),
    "mapv": Term("Clojure", "map"), "filterv": Term("Clojure", "filter"),
    "every?": Term("Clojure", "every"), "some": Term("Clojure", "any"), "nil?": Term("Clojure", "none?"),
    "foldl": Term("Racket", "fold"), "foldr": Term("Racket", "fold-right"),
    "==": Term("Python", "="), "===": Term("JavaScript", "="), "&&": Term("JavaScript", "and"),
    "||": Term("JavaScript", "or"), "!": Term("JavaScript", "not"), "**": Term("Python", "expt"),
    "^": Term("OpenSCAD", "expt"), "progn": Term("Common Lisp", "begin"), "random.random": Term("Python", "random"),
    "random.uniform": Term("Python", "uniform"), "random.randint": Term("Python", "py-randint"),
    "vector-length": Term("Scheme", "length"), "string-length": Term("Scheme", "length"),
    "linear_extrude": Term("OpenSCAD", hint="write `(extrude profile height)`, which extrudes along +z"),
    "rotate_extrude": Term("OpenSCAD", hint="write `(lathe profile)`, which turns a profile around the y axis"),
    "revolve": Term("CadQuery", "lathe"), "subtract": Term("CSG", "difference"),
    "intersect": Term("CSG", "intersection"),
    "fillet": Term("build123d", hint="write `(rounded solid radius)`, which rounds all outer edges, or for a profile "
                   "`(offset-profile (offset-profile profile (- r)) r)`"),
    "bevel": Term("Blender", hint="write `(rounded solid radius)`, which rounds all outer edges"),
    "chamfer": Term("build123d", hint="the `minkowski` of a smaller solid and a double cone has bevelled "
                    "edges; `(rounded solid radius)` rounds them"),
    "offset": Term("OpenSCAD", hint="write `(offset-profile profile distance)`, or `(offset-solid solid distance)`"),
    "thicken": Term("build123d", hint="write `(offset-solid solid distance)`, or `(shell solid thickness)` for walls"),
    "solidify": Term("Blender", "shell"),
    "cut": Term("CadQuery", hint="write `(difference solid tool)`, or for a plane `(cut-plane solid normal)`"),
    "fuse": Term("build123d", "solid-union"),
    "multmatrix": Term("OpenSCAD", "transform"),
    "polyhedron": Term("OpenSCAD", "mesh"), "linear-extrude": Term("OpenSCAD", "extrude"),
    "rotate-extrude": Term("OpenSCAD", "lathe"), "hollow": Term("CSG", "shell"),
    "nth": Term("Common Lisp", hint="an item is read by `(ref sequence index)`"),
    "aref": Term("Common Lisp", "ref"), "get": Term("Clojure", "ref"), "elt": Term("Common Lisp", "ref"),
    "conj": Term("Clojure", hint="lists are joined by `append`: `(append xs (list x))`"),
    "compose": Term("JavaScript", "@"),
    "matmul": Term("Python", "@"), "np.matmul": Term("Python", "@"), "np.dot": Term("Python", "@"),
    "move": Term("CAD", "translate"), "place": Term("CAD", "transform"), "group": Term("CAD", "union"),
    "combine": Term("CAD", "union"), "assembly": Term("CAD", "union"), "resize": Term("OpenSCAD", "scale"),
    "turn": Term("CAD", "rotate"), "rotation": Term("CAD", "rotate"), "translation": Term("CAD", "translate"),
    "apply-transform": Term("CAD", "transform"), "loop-union": Term("CAD", "union-loop"),
    "module": Term("OpenSCAD", "bind"), "colour": Term("CSS", "color"),
    "hex-color": Term("CSS", "color"), "rgb-color": Term("CSS", "rgb"), "circular-array": Term("CAD", "ring"),
    "polar-array": Term("CAD", "ring"), "linear-array": Term("CAD", "row"), "grid-array": Term("CAD", "grid"),
    "polar-pattern": Term("CAD", "ring"), "circular-pattern": Term("CAD", "ring"),
    "linear-pattern": Term("CAD", "row"), "path-array": Term("CAD", "along"), "curve-array": Term("CAD", "along"),
    "reflect-copy": Term("CAD", "mirror"), "stack-on": Term("CAD", "on-top-of"),
    "place-on-top": Term("CAD", "on-top-of"), "place-on": Term("CAD", "on-top-of"),
    "for/vector": Term("Racket", "for/list"),
    "rem": Term("Clojure", "%"), "div": Term("OCaml", "//"),
    "exact-floor": Term("Racket", "floor"),
    "exact-round": Term("Racket", "round"), "exact-ceiling": Term("Racket", "ceiling"),
    "hash-ref": Term("Racket", "ref"), "vector-map": Term("Scheme", "map"), "evenp": Term("Common Lisp", "even?"),
    "oddp": Term("Common Lisp", "odd?"),
    "zerop": Term("Common Lisp", "zero?"), "plusp": Term("Common Lisp", "positive?"),
    "minusp": Term("Common Lisp", "negative?"), "endp": Term("Common Lisp", "empty?"),
    "append*": Term("Racket", "append"),
    "nreverse": Term("Common Lisp", "reverse"), "remove-if-not": Term("Common Lisp", "filter"),
    "remove-if": Term("Common Lisp", "remove"), "reduce-left": Term("Scheme", "fold-left"),
    "string-concat": Term("Lisp", "string-append"),
    "display": Term("Scheme", "print"), "printf": Term("C", "print"), "power": Term("Python", "expt"),
    "throw": Term("JavaScript", "error"), "size": Term("JavaScript", "length"), "head": Term("Haskell", "first"),
    "random.choice": Term("Python", "choice"), "np.deg2rad": Term("Python", "deg"), "np.radians": Term("Python", "deg"),
    "deg2rad": Term("Python", "deg"), "λ": Term("Scheme", "lambda"), "otherwise": Term("Common Lisp", "else"),
    "math.radians": Term("Python", "deg"), "math.degrees": Term("Python", "to-degrees"),
    "np.degrees": Term("Python", "to-degrees"), "np.rad2deg": Term("Python", "to-degrees"),
    "rad2deg": Term("Python", "to-degrees"),
}  # fmt: skip

# Functions of a module that are called the same here, or as the second name says.
MODULES = ("math", "Math", "np", "numpy")
SAME = frozenset(("sin", "cos", "tan", "asin", "acos", "atan", "sqrt", "exp", "log", "floor", "abs", "min", "max",
                   "hypot", "round", "cross", "dot", "linspace", "arange", "array", "zeros", "ones", "eye", "sign",
                   "mean", "sum", "clip"))  # fmt: skip
OTHER = {"ceil": "ceiling", "pow": "expt", "atan2": "atan", "fabs": "abs", "power": "expt", "random": "random"}

INFIX = "the operator comes first"
_LAMBDA = "functions are written `lambda`, and parameters of a word with a colon, as `(lambda (:size) ...)`"
_COLLECT = "`for/union` collects the entities of a loop, `for/list` its values"
_VALUES = "`for/list` collects the values of a loop"
_TESTS = "several tests make a `cond`"
FORMS: Sequence[Idiom] = (
    Idiom("Clojure", "(defn ?name [?args ...] ?body ...)", "(define (?name ?args ...) ?body ...)",
         "functions are defined by `define`", "name"),
    Idiom("Common Lisp", "(defun ?name (?args ...) ?body ...)", "(define (?name ?args ...) ?body ...)",
         "functions are defined by `define`", "name"),
    Idiom("Python", "(def (?name ?args ...) ?body ...)", "(define (?name ?args ...) ?body ...)",
         "functions are defined by `define`", "name"),
    Idiom("Python", "(def ?name (?args ...) ?body ?more ...)", "(define (?name ?args ...) ?body ?more ...)",
         "functions are defined by `define`", "name"),
    Idiom("Clojure", "(def ?name ?value)", "(define ?name ?value)", "names are defined by `define`", "name"),
    Idiom("Python", "(define ?name (?args ...) : ?body ...)", "(define (?name ?args ...) ?body ...)",
         "the name and the parameters of a function stand in one list, without `:`", "name"),
    Idiom("Common Lisp", "(define ?name (?parameters ...) ?body ?more ...)",
         "(define (?name ?parameters ...) ?body ?more ...)",
         "the name and the parameters of a function stand in one list", "name"),
    Idiom("Common Lisp", "(defvar ?name ?value)", "(define ?name ?value)", "names are defined by `define`", "name"),
    Idiom("Common Lisp", "(defparameter ?name ?value)", "(define ?name ?value)",
         "names are defined by `define`", "name"),
    Idiom("Common Lisp", "(defconstant ?name ?value)", "(define ?name ?value)",
         "names are defined by `define`", "name"),
    Idiom("Python", "(define ?name = ?value)", "(define ?name ?value)", "`define` takes no `=`", "name"),
    Idiom("JavaScript", "(const ?name ?value)", "(define ?name ?value)", "names are defined by `define`", "name"),
    Idiom("JavaScript", "(var ?name ?value)", "(define ?name ?value)", "names are defined by `define`", "name"),
    Idiom("JavaScript", "(let ?name ?value)", "(define ?name ?value)", "names are defined by `define`", "name"),
    Idiom("Common Lisp", "(setq ?name ?value)", "(define ?name ?value)",
         "names are defined by `define`, and changed by `set!`", "name"),
    Idiom("Common Lisp", "(setf (nth ?i ?xs) ?value)", "(set-ref! ?xs ?i ?value)",
         "an item is changed by `(set-ref! sequence index value)`", is_sure=False),
    Idiom("Common Lisp", "(setf (aref ?xs ?i) ?value)", "(set-ref! ?xs ?i ?value)",
         "an item is changed by `(set-ref! sequence index value)`"),
    Idiom("Common Lisp", "(setf (gethash ?key ?table) ?value)", "(set-ref! ?table ?key ?value)",
         "a table is changed by `(set-ref! table key value)`"),
    *(Idiom(language, pattern, "(define-record ?name ?fields ...)", "records are defined by `define-record`", "name")
      for language, pattern in (("Racket", "(struct ?name (?fields ...))"),
                                ("Racket", "(define-struct ?name (?fields ...))"),
                                ("Common Lisp", "(defstruct ?name ?fields ...)"),
                                ("Clojure", "(defrecord ?name [?fields ...])"))),
    Idiom("Common Lisp", "(setf ?name ?value)", "(set! ?name ?value)", "variables are changed by `set!`"),
    Idiom("Clojure", "(fn [?args ...] ?body ...)", "(lambda (?args ...) ?body ...)", _LAMBDA),
    Idiom("Clojure", "(fn (?args ...) ?body ...)", "(lambda (?args ...) ?body ...)", _LAMBDA),
    Idiom("JavaScript", "(function (?args ...) ?body ...)", "(lambda (?args ...) ?body ...)",
         "functions are written `lambda`"),
    Idiom("Clojure", "(λ [?args ...] ?body ...)", "(lambda (?args ...) ?body ...)",
         "the parameters of `lambda` stand in parentheses"),
    Idiom("JavaScript", "((?args ...) => ?body ...)", "(lambda (?args ...) ?body ...)",
         "functions are written `lambda`"),
    Idiom("Python", "(lambda: ?body ...)", "(lambda () ?body ...)", "the parameters of `lambda` stand in parentheses"),
    Idiom("Python", "(lambda ?a ?x: ?body ...)", "(lambda (?a ?x) ?body ...)",
         "the parameters of `lambda` stand in parentheses", "x"),
    Idiom("Python", "(lambda ?a ?b ?x: ?body ...)", "(lambda (?a ?b ?x) ?body ...)",
         "the parameters of `lambda` stand in parentheses", "x"),
    Idiom("Python", "(lambda ?x: ?body ...)", "(lambda (?x) ?body ...)",
         "the parameters of `lambda` stand in parentheses", "x"),
    Idiom("Clojure", "(let [?pairs ...] ?body ...)", "(let* (?pairs/2 ...) ?body ...)",
         "each binding of `let` stands in parentheses"),
    Idiom("Clojure", "(let {?pairs ...} ?body ...)", "(let* (?pairs/2 ...) ?body ...)",
         "each binding of `let` stands in parentheses"),
    Idiom("Clojure", "(when-let [?name ?value] ?body ...)", "(let ((?name ?value)) (when ?name ?body ...))",
         "use `let` and `when`"),
    Idiom("Python", "(?name = ?value)", "(?name ?value)", "a binding is `(name value)`, without `=`"),
    Idiom("Common Lisp", "(dotimes (?i ?n) ?body ...)", "(for/union ((?i ?n)) ?body ...)",
         _COLLECT),
    Idiom("Clojure", "(dotimes [?i ?n] ?body ...)", "(for/union ((?i ?n)) ?body ...)",
         _COLLECT),
    Idiom("Common Lisp", "(dolist (?x ?xs) ?body ...)", "(for/union ((?x ?xs)) ?body ...)",
         _COLLECT),
    Idiom("Clojure", "(doseq [?x ?xs] ?body ...)", "(for/union ((?x ?xs)) ?body ...)",
         _COLLECT),
    Idiom("Clojure", "(for [?x ?xs] ?body ...)", "(for/union ((?x ?xs)) ?body ...)",
         _COLLECT),
    Idiom("Python", "(for ?x in range (?n) : ?body ...)", "(for/union ((?x ?n)) ?body ...)",
         _COLLECT),
    Idiom("JavaScript", "(bind ?word {?body ...})", "(bind ?word (lambda () (?body ...)))",
         "a word is bound to a function"),
    Idiom("Python", "(for ?x in range (?n ...) ?body ...)", "(for/union ((?x (range ?n ...))) ?body ...)",
         _COLLECT),
    Idiom("Python", "(for ?x in ?xs ?body ...)", "(for/union ((?x ?xs)) ?body ...)",
         _COLLECT),
    Idiom("JavaScript", "(for (?x in ?xs) ?body ...)", "(for/union ((?x ?xs)) ?body ...)",
         _COLLECT),
    Idiom("JavaScript", "(for (?x of ?xs) ?body ...)", "(for/union ((?x ?xs)) ?body ...)",
         _COLLECT),
    Idiom("Common Lisp", "(loop for ?x in ?xs collect ?body)", "(for/list ((?x ?xs)) ?body)",
         _VALUES),
    Idiom("Common Lisp", "(loop for ?x below ?n collect ?body)", "(for/list ((?x ?n)) ?body)",
         _VALUES),
    Idiom("Common Lisp", "(loop for ?x from ?a to ?b collect ?body)", "(for/list ((?x (range ?a (+ ?b 1)))) ?body)",
         _VALUES),
    Idiom("Common Lisp", "(loop for ?x from ?a below ?b collect ?body)", "(for/list ((?x (range ?a ?b))) ?body)",
         _VALUES),
    Idiom("Common Lisp", "(loop for ?x in ?xs do ?body ...)", "(for/union ((?x ?xs)) ?body ...)",
         _COLLECT),
    Idiom("Python", "[?body for ?x in range (?n)]", "(for/list ((?x ?n)) ?body)",
         _VALUES, "x"),
    Idiom("Python", "[?body for ?x in range (?n ...)]", "(for/list ((?x (range ?n ...))) ?body)",
         _VALUES, "x"),
    Idiom("Python", "[?body for ?x in ?xs]", "(for/list ((?x ?xs)) ?body)",
         _VALUES, "x"),
    Idiom("Common Lisp", "(funcall ?f ?args ...)", "(?f ?args ...)", "a function is called as `(f x)`"),
    Idiom("Scheme", "(add1 ?x)", "(+ ?x 1)", "add one with `+`"),
    Idiom("Scheme", "(sub1 ?x)", "(- ?x 1)", "subtract one with `-`"),
    Idiom("Python", "(not= ?a ?b)", "(not (= ?a ?b))", "inequality is `(not (= a b))`"),
    Idiom("Python", "(!= ?a ?b)", "(not (= ?a ?b))", "inequality is `(not (= a b))`"),
    Idiom("Common Lisp", "(/= ?a ?b)", "(not (= ?a ?b))", "inequality is `(not (= a b))`"),
    Idiom("Clojure", "(inc ?x)", "(+ ?x 1)", "add one with `+`"),
    Idiom("Clojure", "(dec ?x)", "(- ?x 1)", "subtract one with `-`"),
    Idiom("Common Lisp", "(1+ ?x)", "(+ ?x 1)", "add one with `+`"),
    Idiom("Common Lisp", "(1- ?x)", "(- ?x 1)", "subtract one with `-`"),
    Idiom("Common Lisp", "(incf ?x)", "(set! ?x (+ ?x 1))", "variables are changed by `set!`"),
    Idiom("JavaScript", "(++ ?x)", "(set! ?x (+ ?x 1))", "variables are changed by `set!`"),
    Idiom("Python", "(?x += ?y)", "(set! ?x (+ ?x ?y))", "variables are changed by `set!`"),
    Idiom("Racket", "(build-list ?n)", "(iota ?n)", "the numbers from 0 are `(iota n)`"),
    Idiom("Racket", "(build-list ?n ?f)", "(map ?f (iota ?n))", "the numbers from 0 are `(iota n)`"),
    Idiom("Racket", "(build-vector ?n ?f)", "(map ?f (iota ?n))", "the numbers from 0 are `(iota n)`"),
    Idiom("Common Lisp", "(nth ?index ?xs)", "(ref ?xs ?index)", "an item is read by `(ref sequence index)`"),
    Idiom("Clojure", "(nth ?xs ?index)", "(ref ?xs ?index)", "an item is read by `(ref sequence index)`"),
    Idiom("Clojure", "(nth ?plural ?i)", "(ref ?plural ?i)", "an item is read by `(ref sequence index)`",
          is_sure=False),
    Idiom("Common Lisp", "(nth ?i ?xs)", "(ref ?xs ?i)", "an item is read by `(ref sequence index)`", is_sure=False),
    Idiom("JavaScript", "(foreach ?x ?xs ?body ...)", "(for/union ((?x ?xs)) ?body ...)",
         _COLLECT),
    Idiom("Racket", "(for/each (?clauses ...) ?body ...)", "(for/union (?clauses ...) ?body ...)",
         "`for/union` collects the entities of a loop, `for` none", is_sure=False),
    *(Idiom("CAD", f"(for/{name} (?clauses ...) ?body ...)", "(for/union (?clauses ...) ?body ...)", _COLLECT)
      for name in ("all", "entities", "parts", "scene", "group")),
    *(Idiom("Racket", f"(for/{name} (?clauses ...) ?body ...)", "(for/list (?clauses ...) ?body ...)", _VALUES)
      for name in ("array", "collect")),
    *(Idiom("Racket", f"(for/{name} (?clauses ...) ?body ...)", f"(apply {head} (for/list (?clauses ...) ?body ...))",
            _VALUES)
      for name, head in (("max", "max"), ("min", "min"), ("product", "*"))),
    Idiom("Python", "(if ?test then ?a)", "(when ?test ?a)", "`if` has no `then`"),
    Idiom("Python", "(if ?test then ?a else ?b)", "(if ?test ?a ?b)", "`if` has no `then` and `else`"),
    Idiom("Python", "(if ?test ?a else ?b)", "(if ?test ?a ?b)", "`if` takes the second value without `else`"),
    Idiom("Python", "(if ?test ?a elif ?other ?b)", "(cond (?test ?a) (?other ?b))", _TESTS),
    Idiom("Python", "(if ?test ?a elif ?other ?b else ?c)", "(cond (?test ?a) (?other ?b) (else ?c))",
         _TESTS),
    Idiom("JavaScript", "(if ?test ?a else if ?other ?b)", "(cond (?test ?a) (?other ?b))",
         _TESTS),
    Idiom("JavaScript", "(if ?test ?a else if ?other ?b else ?c)", "(cond (?test ?a) (?other ?b) (else ?c))",
         _TESTS),
    Idiom("JavaScript", "(bind ?word (?args ...) => ?body ...)", "(bind ?word (lambda (?args ...) ?body ...))",
         "functions are written `lambda`"),
    Idiom("Python", "(when ?test ?a else ?b)", "(if ?test ?a ?b)", "`if` takes the second value without `else`"),
    Idiom("Python", "(return ?x)", "?x", "the last expression of a body is its value"),
    Idiom("Clojure", "(-> ?x ?body ...)", "", "nest the calls: `(g (f x))`"),
    Idiom("Clojure", "(->> ?x ?body ...)", "", "nest the calls: `(g (f x))`"),
    Idiom("Common Lisp", "(#' ?name)", "?name", "a function is named without `#'`"),
    Idiom("Clojure", "(call ?word {?pairs ...})", "(call ?word ?pairs ...)",
         "attributes are written one after another, without braces"),
    Idiom("Clojure", "{?pairs ...}", "(table ?pairs ...)", "a table is written `(table key value ...)`", is_sure=False),
    Idiom("OpenSCAD", "(translate ?entity ?vector)", "(transform ?entity (translate ?vector))",
         "`translate` makes a pose; `transform` applies it to an entity"),
    Idiom("OpenSCAD", "(translate ?child [?xs ...])", "(transform ?child (translate [?xs ...]))",
         "`translate` makes a pose; `transform` applies it to an entity"),
    Idiom("OpenSCAD", "(rotate ?entity ?a ?vector)", "(transform ?entity (rotate ?a ?vector))",
         "`rotate` makes a pose; `transform` applies it to an entity"),
    Idiom("OpenSCAD", "(rotate ?child ?a [?xs ...])", "(transform ?child (rotate ?a [?xs ...]))",
         "`rotate` makes a pose; `transform` applies it to an entity"),
    Idiom("OpenSCAD", "(scale ?entity ?v)", "(transform ?entity (scale ?v))",
         "`scale` makes a pose; `transform` applies it to an entity"),
    Idiom("OpenSCAD", "(translate ?v ?child)", "(transform ?child (translate ?v))",
         "`translate` makes a pose; `transform` applies it to an entity"),
    Idiom("OpenSCAD", "(translate ?v ?child ?more ...)", "(transform (union ?child ?more ...) (translate ?v))",
         "`translate` makes a pose; `transform` applies it to an entity"),
    Idiom("OpenSCAD", "(rotate [?a ?b ?c] ?child)", "",
         "`rotate` takes an angle in radians and an axis: `(transform part (rotate (deg 90) [0 1 0]))`"),
    Idiom("OpenSCAD", "(rotate ?a ?axis ?child)", "(transform ?child (rotate ?a ?axis))",
         "`rotate` makes a pose; `transform` applies it to an entity"),
    Idiom("OpenSCAD", "(scale ?s ?child)", "(transform ?child (scale ?s))",
         "`scale` makes a pose; `transform` applies it to an entity"),
    Idiom("OpenSCAD", "(color ?c ?child)", "", "the color is an attribute of the call: `:color (color \"red\")`"),
    *(Idiom("Python", f"(?a {op} ?b)", f"({name} ?a ?b)", INFIX)
      for op, name in (("+", "+"), ("-", "-"), ("*", "*"), ("/", "/"), ("%", "%"), ("//", "//"), ("**", "expt"),
                       ("^", "expt"), ("<", "<"), (">", ">"), ("<=", "<="), (">=", ">="), ("==", "="),
                       ("and", "and"), ("or", "or"), ("&&", "and"), ("||", "or"))),
    *(Idiom("Python", f"(?a {op} ?b {op} ?c)", f"({name} ?a ?b ?c)", INFIX)
      for op, name in (("+", "+"), ("*", "*"))),
)  # fmt: skip

_NUMBER = r"[-+]?(?:\d++(?:\.\d*+)?|\.\d+)"
WORD = r"[A-Za-z_][\w-]*"
SYMBOL = r"[A-Za-z_*+][^\s\"']*"
SINGLE_QUOTES = r"(?<![\w\"])'([^'\n()\[\]{}\"]+)'"
QUOTED_FUNCTION = r"(?<![\w])#'(?=\w)"
COLON = r"(?<=\)):(?=\s)"
SPELLINGS: Sequence[Spelling] = (
    Spelling("JavaScript", r"(?m)(?<![^\s])//(?=[^\n]*$)[^\n]*", "", "a comment begins with `;`"),
    Spelling("Racket", r"(?m)^#lang\b[^\n]*", "", "a program names no language: leave the line out"),
    Spelling(
        "OpenSCAD",
        rf"\[({_NUMBER}):({_NUMBER})\]",
        r"(range \1 (+ \2 1))",
        "a range is `(range start end)`, without its end",
    ),
    Spelling(
        "Python",
        r"(?m)^[ \t]*#(?!lang\b)(?![|;\\(tf])[^\n]*|(?m:^[ \t]*#[tf]\w[^\n]*)",
        "",
        "a comment begins with `;`",
    ),
    Spelling("Python", r"(?<=[\s)\]])#(?= )[^\n]*", "", "a comment begins with `;`"),
    Spelling("Haskell", r"(?m)^[ \t]*--+(?= )[^\n]*", "", "a comment begins with `;`"),
    Spelling("Markdown", r"(?m)^[ \t]*```[\w-]*[ \t]*$\n?", "", "a program has no code fences"),
    Spelling("JavaScript", r"/\*.*?\*/", "", "a comment of several lines is `#| ... |#`"),
    Spelling("Python", SINGLE_QUOTES, r'"\1"', "strings stand in double quotes"),
    Spelling("Python", r"\bf(?=\")", "", 'values are put into a text by `(format "{} m" x)`'),
    Spelling("CSS", rf"(?<![\w#])({_NUMBER})deg\b", r"(deg \1)", "angles are in radians; `deg` converts degrees"),
    Spelling("CSS", rf"(?<![\w#])({_NUMBER})°", r"(deg \1)", "angles are in radians; `deg` converts degrees"),
    Spelling("CSS", rf"(?<![\w#])({_NUMBER})%", r"(/ \1 100)", "shares are numbers from 0 to 1"),
    Spelling("CSS", rf"(?<![\w#])({_NUMBER})(?:px|pt|cm|mm|m|in|em)\b", r"\1", "lengths have no unit"),
    Spelling("CSS", r"(?<=\(color )#([0-9a-fA-F]{6}|[0-9a-fA-F]{3})\b", r'"#\1"', "a color is a string"),
    Spelling(
        "CSS",
        r"(?<![\w\"])(?<!\(color )#([0-9a-fA-F]{6}|[0-9a-fA-F]{3})\b",
        r'(color "#\1")',
        "colors are converted by `color`",
    ),
    Spelling("Python", r"(?<![\w.])(\d+)_(\d{3})\b", r"\1\2", "digits of a number are not grouped"),
    Spelling("Scheme", r"#\(([^()\[\]]*)\)", r"[\1]", "an array is written in square brackets"),
    Spelling("Scheme", r"#\\(\w)(?!\w)", r'"\1"', "a character is a string of length 1"),
    Spelling("Common Lisp", QUOTED_FUNCTION, "", "a function is named without `#'`"),
    Spelling("HTML", rf"(?<=[\s(])(:{WORD})=(?=[\w\"(\[.-])", r"\1 ", "an attribute is `:name value`"),
    Spelling(
        "OpenSCAD or Python", rf"(?<=[\s(])({WORD})\s*=\s*(?=[\[(\"'\w.:<+-])", r":\1 ", "an attribute is `:name value`"
    ),
    Spelling("JavaScript", rf"(?<=[\s({{])({WORD}):(?=[\s\[(\"'\d.-])", r":\1", "an attribute is `:name value`"),
    Spelling(
        "Python",
        rf"(?<![\w.$\"])({WORD})\.([xyz])\b(?![.(])",
        r"(\2-of \1)",
        "a coordinate is read by `x-of`, `y-of` or `z-of`, the field of a record by its function, such as `point-x`",
    ),
    Spelling(
        "Python",
        rf"(?<![\w.])({WORD}|{_NUMBER})\*\*({WORD}|{_NUMBER})(?![\w.*])",
        r"(expt \1 \2)",
        INFIX,
    ),
    Spelling(
        "Python",
        rf"(?<![\w.*/+-])(?!for/|std/)({WORD}|{_NUMBER})([*/+])({WORD}|{_NUMBER})(?![\w.*/+-])",
        r"(\2 \1 \3)",
        INFIX,
    ),
    Spelling("Racket", rf"#:({WORD})", r":\1", "a keyword is written `:name`"),
    Spelling("typeset text", r"[“”„]([^“”„\"\n]*)[“”]", r'"\1"', "strings stand in straight quotes"),
    Spelling("typeset text", r"[−–](?=[\d.])", "-", "a minus is the character `-`"),
    Spelling("Python", COLON, "", "forms have no `:` before their parts"),
    Spelling("European notation", r"(:[\w-]+\s+-?\d+),(\d+)(?![\d,.])", r"\1.\2", "decimals are separated by a point"),
    Spelling("PHP", rf"\$({WORD})", r"\1", "names have no `$`"),
    Spelling("JavaScript", r";(?=\s*[)\]}])", "", "statements have no `;` at their end"),
)

# Text that is another language as a whole, by lines that only that language has.
LANGUAGES: Sequence[tuple[str, re.Pattern[str], str]] = (
    ("Python", re.compile(r"^(?:def \w+\(.*\).*:|class \w+.*:|import \w+|from \w[\w.]* import|for \w.* in .*:|"
                          r"if .*:|while .*:|@\w+|with .*:|return\b|print\(|\w+ ?= ?\w[\w.]*\()"),
     "translate it with `scenelang transpile FILE.py`, or give the file the extension .py"),
    ("OpenSCAD", re.compile(r"^(?:module \w+\(|\$fn ?=|(?:translate|rotate|scale|color|difference|union|hull|"
                            r"linear_extrude|cube|sphere|cylinder|rotate_extrude)\(|include <|use <|for ?\(\w+ ?=)"),
     "a part is placed by `(transform (call \"cube\" :scale 2) (translate [1 2 3]))`"),
    ("JavaScript", re.compile(r"^(?:function \w+\(|(?:const|let|var) \w+ ?=|export |import .* from|\w+\.\w+\(|=>)"),
     "a program is made of `(bind \"word\" (lambda () ...))` forms"),
    ("JSON", re.compile(r"^[{\[]\s*(?:$|\"[\w-]+\"\s*:)|^\s*\"[\w-]+\"\s*:"),
     "a scene as JSON is read from a file with the extension .json"),
    ("prose", re.compile(r"^[A-Z][\w',;:`-]*(?: +[\w',;:`\"()-]+){3,}[.:!]?$"), "a comment begins with `;`"),
    ("C", re.compile(r"^(?:#include|int main|void \w+\()"),
     "a program is made of `(bind \"word\" (lambda () ...))` forms"),
)  # fmt: skip
