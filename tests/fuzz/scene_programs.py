"""Small random programs of the language with parts that look suspicious: what nothing uses, what is always true, bodies
of one form, effects and mistakes in odd places. They are drawn from a `random.Random`, fast, for long runs."""

from __future__ import annotations

from random import Random

LITERALS = ("0", "1", "2", "3", "-1", "1.", "0.5", "#t", "#f", "none", '"a"', '"b"', "'(1 2)", "'b", "[1 2 3]", "nan")
NUMBERS = ("0", "1", "2", "3", "-1", "0.5", "2.5")
MACROS = (
    "(define-syntax my-or (syntax-rules () ((_ a b) (let ((t a)) (if t t b)))))",
    "(define-syntax both (syntax-rules () ((_ a b) (begin (print 'both (quote a)) (let () a b)))))",
    "(define-syntax unless2 (syntax-rules (then) ((_ c then e) (if c none e))))",
    "(define-syntax swap! (syntax-rules () ((_ a b) (let ((tmp a)) (set! a b) (set! b tmp)))))",
    "(define x1 7)\n(define-syntax outer (syntax-rules () ((_ a) (list x1 a))))",
    "(define (y1 a) (list 'outer a))\n(define-macro (outer2 a) `(,y1 ,a))",
)
COMMENTS = ("", "", "", "; a note\n", "#| a block |# ", "#;(hidden 1) ")


class Programs:
    """Draws programs one after another."""

    def __init__(self, seed: int) -> None:
        self.random = Random(seed)
        self.count = 0
        self.macros: list[str] = []

    def program(self) -> str:
        """The text of one program."""
        pick = self.random
        self.count = 0
        self.macros = pick.sample(MACROS, pick.choice((0, 0, 1, 2)))
        forms = [*self.macros]
        names: list[str] = []
        for _ in range(pick.randint(0, 2)):
            name = self._name()
            forms.append(f"(define {name} {self._value(names, 2)})")
            names.append(name)
        words: list[str] = []
        for word in ("part", "other", "scene")[pick.choice((1, 2, 2, 2)) :]:
            forms.append(
                f'(bind "{word}" (lambda () {self._body(names, words, pick.choice((0, 1, 1, 2, 2, 3)), shape=True)}))'
            )
            words.append(word)
        if pick.random() < 0.2:
            forms.insert(pick.randint(0, len(forms)), f"(print {self._value([], 2)})")
        if pick.random() < 0.3:
            forms.append('(scene "scene")')
        return "\n".join(pick.choice(COMMENTS) + form for form in forms) + "\n"

    def _name(self) -> str:
        if self.count and self.random.random() < 0.15:  # a name that may be visible already
            return self.random.choice("xy") + "1"
        self.count += 1
        return self.random.choice("xyzfgk") + str(self.count)

    def _body(self, names: list[str], words: list[str], depth: int, shape: bool = False) -> str:
        """The forms of a body: definitions that may be unused, effects, and a value."""
        pick, names = self.random, list(names)
        forms: list[str] = []
        for _ in range(pick.choice((0, 1, 1, 2))):
            kind = pick.random()
            if kind < 0.55:
                name = self._name()
                forms.append(self._definition(name, names, depth))
                names.append(name)
            elif kind < 0.65 and names:
                forms.append(f"(set! {pick.choice(names)} {self._value(names, min(depth - 1, 1))})")
            elif kind < 0.72:
                inner = self._name()
                forms.append(f"(begin (define {inner} {self._value(names, min(depth - 1, 1))}))")
            else:
                forms.append(self._effect(names, depth - 1))
        forms.append(self._shape(names, words, depth) if shape else self._value(names, depth))
        return pick.choice((" ", "\n  ", "")).join(self._apart(form) for form in forms)

    def _apart(self, form: str) -> str:
        return form if form.startswith("(") else f" {form} "

    def _definition(self, name: str, names: list[str], depth: int) -> str:
        pick = self.random
        if pick.random() < 0.25:
            body = self._body([*names, f"{name}a"], [], depth - 1) if depth else "1"
            return f"(define ({name} {name}a) {body})"
        return f"(define {name} {self._value(names, depth - 1)})"

    def _effect(self, names: list[str], depth: int) -> str:
        pick = self.random
        if depth <= 0:
            return pick.choice(("(print 1)", "(random)", "(print 'x)"))
        return pick.choice((
            lambda: f"(print {self._value(names, depth - 1)})",
            lambda: f"(when {self._test(names, depth - 1)} {self._body(names, [], depth - 1)})",
            lambda: f"(if {self._test(names, depth - 1)} {self._value(names, 0)} {self._value(names, depth - 1)})",
            lambda: f"(for ((i (range 2))) {self._body([*names, 'i'], [], depth - 1)})",
            lambda: "(random)",
        ))()  # fmt: skip

    def _test(self, names: list[str], depth: int) -> str:
        pick = self.random
        constant = pick.choice(("#t", "#f", "1", "none", "(= 1 1)", "(equal? 1 1.0)", "(< 2 1)", "car", "(eq? 'a 'a)"))
        if pick.random() < 0.5:
            return constant
        if names and pick.random() < 0.5:
            name = pick.choice(names)
            return pick.choice((f"(= {name} {name})", f"(equal? {name} {name})", name, f"(not {name})"))
        return f"(< {self._value(names, depth - 1)} {self._value(names, depth - 1)})"

    def _value(self, names: list[str], depth: int) -> str:
        pick = self.random
        if depth <= 0 or pick.random() < 0.3:
            return pick.choice(names) if names and pick.random() < 0.5 else pick.choice(LITERALS)
        down = lambda: self._value(names, depth - 1)
        inner = self._name()
        choices = [
            lambda: f"(+ {pick.choice(NUMBERS)} {down()})",
            lambda: f"(if {self._test(names, depth - 1)} {down()} {down()})",
            lambda: f"(+ 1(if {self._test(names, depth - 1)} {down()} {down()})2)",
            lambda: f"(let (({inner} {down()})) {self._body([*names, inner], [], depth - 1)})",
            lambda: f"(let* (({inner} {down()}) (w{inner} {inner})) {self._body([*names, inner], [], depth - 1)})",
            lambda: f"(begin {down()} {down()})",
            lambda: f"(cond ({self._test(names, depth - 1)} {self._body(names, [], depth - 1)}) (else {down()}))",
            lambda: f"(and {self._test(names, depth - 1)} {down()})",
            lambda: f"(or {self._test(names, depth - 1)} {down()})",
            lambda: f"((lambda ({inner}) {self._body([*names, inner], [], depth - 1)}) {down()})",
            lambda: f"(for/list (({inner} '(1 2))) {self._body([*names, inner], [], depth - 1)})",
            lambda: f"(list {down()} {down()})",
            lambda: f"`(1 ,{down()} 'q)",
            lambda: f"(let/ec stop {self._effect(names, depth - 1)} (stop {down()}) {down()})",
            lambda: f'(guard (e (#t (print \'caught) {down()})) {down()} (error "no"))',
            lambda: "(random)",
            lambda: f"[{pick.choice(NUMBERS)} {pick.choice([*NUMBERS, *names])}]",
        ]
        if any("my-or" in macro for macro in self.macros):
            choices += [lambda: f"(my-or {down()} {down()})"] * 3
        if any("both" in macro for macro in self.macros):
            choices += [lambda: f"(both (define {inner} {down()}) {down()})"] * 3
        if any("unless2" in macro for macro in self.macros):
            choices += [lambda: f"(unless2 {self._test(names, depth - 1)} then {down()})"] * 2
        if any("define-syntax outer" in macro for macro in self.macros):
            choices += [lambda: f"(outer {down()})"] * 2
            choices += [lambda: f"((lambda ((:x1 {down()})) (outer {down()})) :x1 {pick.choice(NUMBERS)})"]
        if any("define-macro (outer2" in macro for macro in self.macros):
            choices += [lambda: f"(outer2 {down()})"] * 3
        return pick.choice(choices)()

    def _shape(self, names: list[str], words: list[str], depth: int) -> str:
        pick = self.random
        cube = f'(call "{pick.choice(("cube", "sphere"))}" :{pick.choice(("scale", "radius"))} {pick.choice(NUMBERS)})'
        if depth <= 0:
            return cube
        down = lambda: self._shape(names, words, depth - 1)
        choices = [
            lambda: cube,
            lambda: f"(union {down()} {down()})",
            lambda: f"(union-loop 2 (lambda (i) {self._body([*names, 'i'], words, depth - 1, shape=True)}))",
            lambda: f"(transform {down()} (translate [{pick.choice(NUMBERS)} (random) 0]))",
            lambda: f"(if {self._test(names, depth - 1)} {down()} {down()})",
            lambda: f"(let () {self._body(names, words, depth - 1, shape=True)})",
            lambda: f"(begin {self._effect(names, depth - 1)} {down()})",
            lambda: f"(when {self._test(names, depth - 1)} {down()})",
        ]
        if words and pick.random() < 0.3:
            return f'(call "{pick.choice(words)}")'
        return pick.choice(choices)()
