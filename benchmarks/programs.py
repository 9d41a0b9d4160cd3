"""The benchmarks' programs; the last form of each is what is timed."""

from __future__ import annotations

FIB = "(define (fib n) (if (< n 2) n (+ (fib (- n 1)) (fib (- n 2))))) (fib 22)"
LOOP = "(let loop ((i 0) (total 0)) (if (= i 1000000) total (loop (+ i 1) (+ total i))))"
TAK = """
(define (tak x y z)
  (if (not (< y x)) z (tak (tak (- x 1) y z) (tak (- y 1) z x) (tak (- z 1) x y))))
(tak 14 8 2)
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
