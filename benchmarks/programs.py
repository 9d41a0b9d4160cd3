"""The benchmarks' programs; the last form of each is what is timed."""

from __future__ import annotations

FIB = "(define (fib n) (if (< n 2) n (+ (fib (- n 1)) (fib (- n 2))))) (fib 22)"
LOOP = "(let loop ((i 0) (total 0)) (if (= i 1000000) total (loop (+ i 1) (+ total i))))"
TAK = """
(define (tak x y z)
  (if (not (< y x)) z (tak (tak (- x 1) y z) (tak (- y 1) z x) (tak (- z 1) x y))))
(tak 14 8 2)
"""
QUEENS = """
(define (safe? row distance placed)
  (or (null? placed)
      (and (not (= (car placed) row))
           (not (= (car placed) (+ row distance)))
           (not (= (car placed) (- row distance)))
           (safe? row (+ distance 1) (cdr placed)))))
(define (queens n)
  (define (place k placed)
    (if (= k 0)
      1
      (let try ((row 1) (count 0))
        (if (> row n)
          count
          (try (+ row 1) (if (safe? row 1 placed) (+ count (place (- k 1) (cons row placed))) count))))))
  (place n '()))
(queens 7)
"""
STRINGS = """
(define (spell n) (if (= n 0) "" (string-append (spell (- n 1)) (number->string n) ",")))
(define (total k sum) (if (= k 0) sum (total (- k 1) (+ sum (string-length (spell 100))))))
(total 200 0)
"""
VECTORS = """
(define (orbit n position velocity)
  (if (= n 0)
    position
    (orbit (- n 1) (+ position (* velocity 0.01)) (- velocity (* position 0.01)))))
(orbit 100000 [1. 0. 0.] [0. 1. 0.])
"""
TREE = """
(bind "leaf" (lambda () (call "sphere" :radius 0.1)))
(bind "tree"
  (lambda (:level)
    (if (= level 0)
      (call "leaf")
      (let ((bend (uniform 0.2 0.6)) (size (uniform 0.6 0.8)))
        (union
          (call "cylinder" :radius 0.1 :height 1.0)
          (transform (call "tree" :level (- level 1))
            (@ (translate [0 1 0]) (rotate bend [0 0 1]) (scale size)))
          (transform (call "tree" :level (- level 1))
            (@ (translate [0 1 0]) (rotate (- bend) [0 0 1]) (scale size))))))))
(call "tree" :level 14)
"""
NESTED = """
(bind "grid"
  (lambda ()
    (union-loop 30
      (lambda (i)
        (transform
          (union-loop 1000
            (lambda (j)
              (transform (call "cube" :color [1.0 0.0 0.0])
                (@ (translate [i 0 j]) (rotate (* 0.1 j) [0 1 0])))))
          (translate [0 i 0]))))))
(call "grid")
"""
PLACED = """
(bind "row"
  (lambda ()
    (union-loop 100000
      (lambda (i) (transform (call "cube" :color [1.0 0.0 0.0]) (translate [i 0 0]))))))
(call "row")
"""
CHESSBOARD = """
(bind "board"
  (lambda ()
    (union-loop 64
      (lambda (i)
        (define x (% i 8))
        (define z (// i 8))
        (define shade (if (= (% (+ x z) 2) 0) [.9 .9 .9] [.1 .1 .1]))
        (transform (call "cube" :color shade :scale [1 .1 1]) (translate [x 0 z]))))))
(bind "pieces"
  (lambda ()
    (union
      (for*/union ((i (range 8)) ((z color) '((1 [1. 1. 1.]) (6 [0. 0. 0.]))))
        (transform (call "pawn" :color color) (translate [i .1 z])))
      (for*/union (((i name) (enumerate '("rook" "knight" "bishop" "queen" "king" "bishop" "knight" "rook")))
                   ((z color) '((0 [1. 1. 1.]) (7 [0. 0. 0.]))))
        (transform (call name :color color) (translate [i .1 z]))))))
(bind "chessboard" (lambda () (union (call "board") (call "pieces"))))
(call "chessboard")
"""
SPONGE = """
(bind "sponge"
  (lambda (:level)
    (if (= level 0)
      (call "cube")
      (for*/union ((x '(-1 0 1)) (y '(-1 0 1)) (z '(-1 0 1)) :when (< (count (list x y z) 0) 2))
        (transform (call "sponge" :level (- level 1))
          (@ (translate [(/ x 3) (/ y 3) (/ z 3)]) (scale (/ 1 3))))))))
(scene "sponge" :level {level})
"""


def reader_text(size: int) -> str:
    """A program of about ``size`` characters."""
    piece = """
(bind "book-{i}"
  (lambda (:thickness (:height 1.5) (:color [.6 .3 .1]))
    (define cover (call "cube" :color color :scale [thickness height .3]))
    (define label (transform (call "cube" :color [.9 .8 .5]) (translate [0 (* height .2) -.15])))
    (if (> height 2) (union cover) (union cover label))))  ; number {i}
"""
    count = size // len(piece)
    return "".join(piece.replace("{i}", str(i)) for i in range(count))


PRIMITIVES = """
(bind "primitives"
  (lambda ()
    (union-loop {count}
      (lambda (i)
        (transform
          (if (odd? i)
            (call "sphere" :radius .5 :color [(+ .2 (* .003 i)) .5 (- .8 (* .003 i))])
            (call "cube" :color [(+ .2 (* .003 i)) .5 (- .8 (* .003 i))]))
          (translate [(* 2 (% i 15)) 0 (* 2 (// i 15))]))))))
"""
CUBES = """
(bind "cubes"
  (lambda ()
    (union-loop {count}
      (lambda (i) (transform (call "cube") (translate [i 0 0]))))))
"""


def union_of_lines(count: int) -> str:
    """A word of as many members, a line of literals each."""
    lines = "\n".join(
        f'(transform (call "cube" :color [.{i % 10} .5 .5]) (translate [{i % 100} {i // 100 % 100} {i // 10_000}]))'
        for i in range(count)
    )
    return f'(bind "members" (lambda () (union\n{lines})))\n'


def binds(count: int) -> str:
    """A word a line."""
    return "\n".join(f'(bind "w{i}" (lambda () (call "cube" :color [.{i % 10} .5 .5])))' for i in range(count)) + "\n"


def python_lines(count: int) -> str:
    """The members of ``union_of_lines`` in Python, for its compiler."""
    lines = "\n".join(
        f'    transform(call("cube", color=[.{i % 10}, 0, 0]), translate([{i % 99}, {i // 99 % 99}, {i // 9801}])),'
        for i in range(count)
    )
    return f"def members():\n  return union(\n{lines}\n  )\n"


def python_functions(count: int) -> str:
    """The words of ``binds`` in Python."""
    return "\n".join(f'def w{i}(): return call("cube", color=[.{i % 10}, .5, .5])' for i in range(count)) + "\n"
