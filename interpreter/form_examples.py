"""An example of every special form: a small program, and the value of its last expression (None: it has none)."""

from __future__ import annotations

from collections.abc import Mapping

FORM_EXAMPLES: Mapping[str, tuple[str, str | None]] = {
    "quote": ('(quote (a 1 "b"))', '(a 1 "b")'),
    "quasiquote": ("(let ((x 2)) `(x is ,x and then ,@(list 3 4)))", "(x is 2 and then 3 4)"),
    "if": ('(let ((x 2)) (if (> x 1) "more" "less"))', '"more"'),
    "lambda": ("((lambda (x (:by 2)) (* x by)) 5 :by 3)", "15"),
    "define": ("(define (square x)\n  (define factor x)\n  (* factor x))\n(square 4)", "16"),
    "define-values": ("(define-values (width height) (list 3 4))\n(* width height)", "12"),
    "define-record": ("(define-record leg (height .7) (count 4))\n(leg-height (leg :count 3))", "0.7"),
    "define-syntax": (
        "(define-syntax twice\n"
        "  (syntax-rules ()\n"
        "    ((_ part offset) (union part (transform part (translate offset))))))\n"
        '(length (twice (call "cube") [2 0 0]))',
        "2",
    ),
    "syntax-rules": (
        "(define-syntax sum-of\n"
        "  (syntax-rules (to)\n"
        "    ((_ a to b) (for/sum ((n (range a (+ b 1)))) n))))\n"
        "(sum-of 1 to 4)",
        "10",
    ),
    "define-macro": (
        '(define-macro (repeat n expression)\n  `(for/list ((_ (iota ,n))) ,expression))\n(repeat 3 "x")',
        '("x" "x" "x")',
    ),
    "let-syntax": ("(let-syntax ((double (syntax-rules () ((_ x) (* 2 x))))) (double 21))", "42"),
    "letrec-syntax": (
        "(letrec-syntax ((any (syntax-rules () ((_) #f) ((_ x . more) (if x #t (any . more))))))\n  (any #f 3 #f))",
        "#t",
    ),
    "bind": (
        '(bind "ball" (lambda ((:size 1)) (call "sphere" :radius (/ size 2))))\n(bind "pair"\n  (lambda ()\n'
        '    (union (call "ball") (transform (call "ball" :size 2) (translate [2 0 0])))))',
        None,
    ),
    "import": ('(import "std/python.scene" :prefix py/)\n(py/py-+ "a" "b")', '"ab"'),
    "scene": ('(bind "tree" (lambda ((:height 2)) (call "cone" :p1 [0 height 0])))\n(scene "tree" :height 5)', None),
    "param": (
        '(param floors 3 "how many floors" :min 1 :max 9)\n(bind "house"\n  (lambda ()\n'
        '    (union-loop floors (lambda (i) (transform (call "cube") (translate [0 i 0]))))))',
        None,
    ),
    "set!": ("(let ((n 1)) (set! n (+ n 1)) n)", "2"),
    "let": ("(let loop ((n 5) (product 1)) (if (= n 0) product (loop (- n 1) (* n product))))", "120"),
    "let*": ("(let* ((x 3) (y (* x x))) (+ x y))", "12"),
    "letrec": (
        "(letrec ((even (lambda (n) (if (= n 0) #t (odd (- n 1)))))\n"
        "         (odd (lambda (n) (if (= n 0) #f (even (- n 1))))))\n  (even 10))",
        "#t",
    ),
    "letrec*": ("(letrec* ((two 2) (double (lambda (x) (* two x)))) (double 4))", "8"),
    "let-values": ("(let-values (((x y) (list 1 2))) (+ x y))", "3"),
    "let*-values": ("(let*-values (((x y) (list 1 2)) ((z) (list (+ x y)))) z)", "3"),
    "begin": ("(begin 1 2 3)", "3"),
    "begin0": ("(let ((n 1)) (begin0 n (set! n 9)))", "1"),
    "cond": ('(let ((x 0)) (cond ((> x 0) "plus") ((< x 0) "minus") (else "nought")))', '"nought"'),
    "case": ('(case "rook" (("rook" "bishop") 1) (("king") 2) (else 0))', "1"),
    "when": ('(let ((x 2)) (when (> x 1) "more"))', '"more"'),
    "unless": ('(let ((x 2)) (unless (> x 1) "less"))', "none"),
    "and": ("(let ((x 2)) (and (> x 1) (* 2 x)))", "4"),
    "or": ("(let ((x none)) (or x 3))", "3"),
    "do": ("(do ((i 0 (+ i 1)) (sum 0 (+ sum i))) ((= i 5) sum))", "10"),
    "while": ("(let ((n 100)) (while (> n 10) (set! n (/ n 2))) n)", "6.25"),
    "let/ec": ('(let/ec leave (for ((x \'(1 2 7 4))) (when (> x 5) (leave x))) "none found")', "7"),
    "guard": ('(guard (e ((error-is? e "zero-division") "endless")) (/ 1 0))', '"endless"'),
    "assert": ('(let ((x 3)) (guard (e (#t (error-message e))) (assert (< x 2) "too large")))', '"too large"'),
    "for": ("(let ((n 0)) (for ((x '(1 2 3))) (set! n (+ n x))) n)", "6"),
    "for/list": ("(for/list ((x '(1 2 3)) :when (odd? x)) (* x x))", "(1 9)"),
    "for/union": ('(length (for/union ((x \'(-1 1))) (transform (call "cube") (translate [x 0 0]))))', "2"),
    "for/append": ("(for/append ((n '(1 2 3))) (make-list n n))", "(1 2 2 3 3 3)"),
    "for/sum": ("(for/sum ((x '(1 2 3)) (y '(10 20 30))) (* x y))", "140"),
    "for/and": ("(for/and ((x '(1 3 5))) (odd? x))", "#t"),
    "for/or": ("(for/or ((x '(2 3 4))) (and (odd? x) (* 10 x)))", "30"),
    "for/first": ("(for/first ((x '(5 8 9)) :when (even? x)) x)", "8"),
    "for/table": ('(ref (for/table ((name \'("king" "queen")) (height \'(2 1.8))) (list name height)) "queen")', "1.8"),
    "for/set": ("(length (for/set ((x '(1 -1 2))) (abs x)))", "2"),
    "for/fold": ("(for/fold ((total 0) (largest 0)) ((x '(3 9 4))) (list (+ total x) (max largest x)))", "(16 9)"),
    "for*": ("(let ((n 0)) (for* ((x '(1 2)) (y '(10 20))) (set! n (+ n (* x y)))) n)", "90"),
    "for*/list": ("(for*/list ((x '(1 2)) (y (iota x))) (list x y))", "((1 0) (2 0) (2 1))"),
    "for*/union": (
        "(length\n  (for*/union ((x '(-1 0 1)) (z '(-1 0 1)) :unless (= x z 0))\n"
        '    (transform (call "cube") (translate [x 0 z]))))',
        "8",
    ),
    "for*/append": ("(for*/append ((x '(1 2)) (y '(3 4))) (list x y))", "(1 3 1 4 2 3 2 4)"),
    "for*/sum": ("(for*/sum ((x '(1 2)) (y '(10 20))) (* x y))", "90"),
    "for*/and": ("(for*/and ((row '((1 2) (3 4))) (x row)) (> x 0))", "#t"),
    "for*/or": ("(for*/or ((row '((1 2) (3 4))) (x row)) (> x 3))", "#t"),
    "for*/first": ("(for*/first ((x (range 1 20)) (y (range 1 x)) :when (= (* x y) 42)) (list x y))", "(7 6)"),
    "for*/table": ("(length (for*/table ((x '(1 2 3)) (y '(1 2))) (list (* x y) (list x y))))", "5"),
    "for*/set": ("(length (for*/set ((x '(1 2)) (y '(1 2))) (+ x y)))", "3"),
    "for*/fold": (
        '(for*/fold ((longest "")) ((row \'(("a" "oak") ("fir" "birch"))) (s row))\n'
        "  (if (> (length s) (length longest)) s longest))",
        '"birch"',
    ),
}
