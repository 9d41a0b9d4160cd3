"""Functions that converted programs define when they need them, by name: OpenSCAD's shapes and rules."""

from __future__ import annotations

import re

_TEXT = """
;;; A box with one corner at the origin, or around it; `size` is one number or three, all above 0 unless it is nothing.
(define (box size (:center #f) (:color none) (:opacity none))
  (define whole (* size [1 1 1]))
  (if (> (min-of whole) 0)
    (transform (call "cube" :scale whole :color color :opacity opacity)
               (translate (* whole (if center 0 .5))))
    (union)))

;;; A ball as OpenSCAD makes it: rings of corners, none of them at a pole.
(define (ball radius sides (:color none) (:opacity none))
  (define rings (// (+ sides 1) 2))
  (define angles (for/list ((ring rings)) (/ (* pi (+ ring .5)) rings)))
  (define top (* radius (cos (/ pi 2 rings))))
  (define side (for/list ((angle (reverse angles))) (* radius [(sin angle) (cos angle)])))
  (if (> radius 0)
    (transform (lathe (append (list [0 (- top)]) side (list [0 top])) :segments sides :color color :opacity opacity)
               (rotate (deg 90) [1 0 0]))
    (union)))

;;; A cone without its tip, or with it if one of the radii is 0.
(define (frustum height bottom top sides (:center #f) (:color none) (:opacity none))
  (define (upright base taper)
    (extrude (circle base :segments sides) height :taper taper :center center :color color :opacity opacity))
  (cond ((or (<= height 0) (< (min bottom top) 0) (= 0 bottom top)) (union))
        ((>= bottom top) (upright bottom (/ top bottom)))
        (else (transform (upright top (/ bottom top))
                         (@ (translate [0 0 (if center 0 height)]) (scale [1 1 -1]))))))

;;; A rectangle with one corner at the origin.
(define (corner-rectangle width height)
  (polygon [[0 0] [width 0] [width height] [0 height]]))

;;; The number of sides of a circle: `fn` if it is given, else by the least angle in degrees and the least length.
(define (fragments radius (:fn 0) (:fa 12) (:fs 2))
  (cond ((> fn 0) (min 1024 (max 3 (floor fn))))
        ((< radius 1e-6) 5)
        (else (min 1024 (ceiling (max 5 (min (/ 360 (max fa .01)) (/ (* tau radius) (max fs .01)))))))))

;;; A solid in one color.
(define (painted object (:color none) (:opacity none))
  (if (empty? (primitives object))
    (union)
    (solid-union object :color color :opacity opacity)))

;;; The operands that are not empty.
(define (present-solids operands)
  (filter (lambda (operand) (not (empty? (primitives operand)))) operands))

;;; `difference`, whose operands may be empty.
(define (solid-cut base . tools)
  (define real (present-solids tools))
  (if (or (empty? real) (empty? (primitives base)))
    (union base)
    (apply difference base real)))

;;; `intersection`, whose operands may be empty.
(define (solid-common . operands)
  (if (= (length (present-solids operands)) (length operands))
    (apply intersection operands)
    (union)))

;;; `hull`, whose operands may be empty.
(define (solid-hull . operands)
  (define real (present-solids operands))
  (if (empty? real)
    (union)
    (apply hull real)))

;;; `minkowski`, whose operands may be empty.
(define (solid-sum . operands)
  (define real (present-solids operands))
  (if (empty? real)
    (union)
    (for/fold ((sum (first real))) ((operand (rest real))) (minkowski sum operand))))

;;; The profiles that are not empty.
(define (present-profiles operands)
  (filter (lambda (operand) (not (null? operand))) operands))

;;; `profile-union`, whose operands may be empty.
(define (profiles-union . operands)
  (define real (present-profiles operands))
  (if (empty? real)
    (list)
    (apply profile-union real)))

;;; `profile-difference`, whose operands may be empty.
(define (profile-cut base . tools)
  (if (null? base)
    (list)
    (apply profile-difference base (present-profiles tools))))

;;; `profile-intersection`, whose operands may be empty.
(define (profile-common . operands)
  (if (any null? operands)
    (list)
    (apply profile-intersection operands)))

;;; `profile-hull`, whose operands may be empty.
(define (profiles-hull . operands)
  (define real (present-profiles operands))
  (if (empty? real)
    (list)
    (apply profile-hull real)))

;;; `profile-minkowski`, whose operands may be empty.
(define (profile-sum . operands)
  (define real (present-profiles operands))
  (if (empty? real)
    (list)
    (for/fold ((sum (first real))) ((operand (rest real))) (profile-minkowski sum operand))))

;;; The profile that `draw` makes of a solid; nothing of an empty one.
(define (if-solid object draw)
  (if (empty? (primitives object))
    (list)
    (draw object)))

;;; What `make` makes of a profile; nothing of an empty one.
(define (if-profile profile make)
  (if (null? profile)
    (union)
    (make profile)))

;;; A profile grown by `distance`, or shrunk if it is negative, with the round corners of OpenSCAD: so many sides of a
;;; full circle begin at the first edge of a corner, and the last one ends at the other edge.
(define (round-offset profile distance sides)
  (define least (/ pi (acos .75)))
  (define count (max sides least))
  (define way (if (< distance 0) -1 1))
  (define (outwards p q)
    (define along (- q p))
    (* (/ distance (norm along)) [(ref along 1) (- (ref along 0))]))
  (define (turned-by v angle)
    (define c (cos angle))
    (define s (sin angle))
    [(- (* c (ref v 0)) (* s (ref v 1))) (+ (* s (ref v 0)) (* c (ref v 1)))])
  (define pieces
    (for*/append ((contour (profile-union profile)) (i (range 0 (length contour))))
      (define size (length contour))
      (define p (ref contour i))
      (define q (ref contour (remainder (+ i 1) size)))
      (define a (outwards (ref contour (remainder (+ i size -1) size)) p))
      (define b (outwards p q))
      (define angle (atan (cross-of a b) (dot a b)))
      (define steps (max 1 (ceiling (- (/ (* count (abs angle)) tau) .5 1e-9))))
      (define arc
        (for/list ((step (range 0 steps))) (+ p (turned-by a (/ (* way step tau) count)))))
      (cons (list p q (+ q b) (+ p b))
            (if (> (* way angle) 1e-6)
              (list (append (list p) arc (list (+ p b))))
              (list)))))
  (apply (if (> distance 0) profile-union profile-difference) profile (map polygon pieces)))

;;; A changed profile; an empty one stays empty.
(define (map-profile profile change)
  (if (null? profile)
    (list)
    (change profile)))

;;; The corners of a profile, of all of its contours.
(define (profile-points profile)
  (apply append (map ->list (profile-union profile))))

;;; A profile under the matrix of a pose.
(define (profile-by-matrix profile matrix)
  (define (entry row column) (ref (ref matrix row) column))
  (define linear [[(entry 0 0) (entry 1 0)] [(entry 0 1) (entry 1 1)]])
  (for/list ((contour (profile-union profile)))
    (define moved (+ (@ contour linear) [(entry 0 3) (entry 1 3)]))
    (if (< (determinant linear) 0)
      (array (reverse (->list moved)))
      moved)))

;;; A polygon whose contours are paths of indices; what is inside of an even number of them is outside.
(define (polygon-paths points paths)
  (profile-union
    (for/list ((path paths)) (array (for/list ((index path)) (ref points index))))
    :fill :even-odd))

;;; A text moved so that y = 0 is at its "top", "center" or "bottom".
(define (raised-text outline place)
  (define heights (map second (profile-points outline)))
  (define line
    (case place
      (("top") (max-of heights))
      (("center") (/ (+ (max-of heights) (min-of heights)) 2))
      (("bottom") (min-of heights))
      (else 0)))
  (transform-profile outline :move [0 (- line)]))

;;; An extrusion turned by `twist` degrees, clockwise, in layers as OpenSCAD counts them.
(define (twisted profile height twist (:fn 0) (:fa 12) (:fs 2) (:taper 1) (:center #f) (:color none) (:opacity none))
  (define radius (max-of (map norm (profile-points profile))))
  (define turn (abs (deg twist)))
  (define arc-length (if (= turn 0) height (* turn (hypot radius (/ height turn)))))
  (define layers
    (if (> fn 0)
      (/ (* turn fn) tau)
      (min (/ (to-degrees turn) (max fa .01)) (/ arc-length (max fs .01)))))
  (define slices (max 1 (ceiling (/ (to-degrees turn) 120)) (ceiling (- layers 1e-9))))
  (extrude profile height :twist (deg (- twist)) :slices slices :taper taper :center center :color color
           :opacity opacity))

;;; A profile turned around z by `angle` degrees, with as many sides as OpenSCAD takes; x may be below 0 everywhere.
(define (turned profile (:angle 360) (:fn 0) (:fa 12) (:fs 2) (:color none) (:opacity none))
  (define is-full (>= (abs angle) 360))
  (define across (map first (profile-points profile)))
  (define is-left (<= (max-of across) 1e-6))
  (assert (or is-left (>= (min-of across) -1e-6))
          "the profile is on both sides of the axis: all x must be above 0, or below it")
  (define round-sides (fragments (max-of (map abs across)) :fn fn :fa fa :fs fs))
  (define sides (if is-full round-sides (max 1 (floor (/ (* round-sides (abs angle)) 360)))))
  (define part
    (lathe (if is-left (transform-profile profile :scale [-1 1]) profile)
           :angle (if is-full tau (deg (abs angle)))
           :segments (if is-full sides (max 3 (min 1024 (floor (/ (* sides 360) (abs angle))))))
           :color color :opacity opacity))
  (transform part
             (@ (rotate (deg 90) [1 0 0])
                (rotate (if (equal? is-left (and is-full (odd? sides))) 0 pi) [0 1 0])
                (scale [1 1 (if (< angle 0) -1 1)]))))

;;; Three numbers of a vector of two or three.
(define (triple v (filler 0))
  (if (= (length v) 2)
    [(first v) (second v) filler]
    v))

;;; A rotation by degrees: about an axis, or about x, y and z if `angle` is a vector.
(define (turn angle (axis [0 0 1]))
  (if (number? angle)
    (if (= (norm axis) 0) (identity-pose) (rotate (deg angle) axis))
    (@ (rotate (deg (if (> (length angle) 2) (ref angle 2) 0)) [0 0 1])
       (rotate (deg (ref angle 1)) [0 1 0])
       (rotate (deg (ref angle 0)) [1 0 0]))))

;;; A pose of three or four rows.
(define (full-matrix rows)
  (array (append (take (->list rows) 3) (list [0 0 0 1]))))

;;; A solid scaled to a size about the origin; sizes of 0 are kept.
(define (resized object size)
  (define sizes (compute-shape-sizes object))
  (define factors
    (for/list ((new size) (old sizes)) (if (= new 0) 1 (/ new old))))
  (transform object (scale (array factors))))

;;; A color by name or by components from 0 to 1.
(define (color-of c)
  (if (string? c)
    (color c)
    (rgb (* 255 (ref c 0)) (* 255 (ref c 1)) (* 255 (ref c 2)))))

;;; The numbers from `first-one` by `step` up to `last-one`, which is included.
(define (span first-one step last-one)
  (for/list ((i (range 0 (+ 1 (floor (+ 1e-9 (/ (- last-one first-one) step)))))))
    (+ first-one (* i step))))

;;; The numbers that a range of OpenSCAD without a step has: from the smaller end to the larger.
(define (rising first-one last-one)
  (range (min first-one last-one) (+ 1 (max first-one last-one))))

;;; So many random numbers between two.
(define (random-numbers low high count)
  (for/list ((i (range 0 count))) (uniform low high)))

;;; Whether OpenSCAD takes a value for true.
(define (true? x)
  (cond ((number? x) (not (= x 0)))
        ((boolean? x) x)
        ((none? x) #f)
        ((procedure? x) #t)
        (else (not (empty? x)))))

;;; Whether OpenSCAD takes two values for equal: 1 and 1.0 are.
(define (same? a b)
  (cond ((and (number? a) (number? b)) (= a b))
        ((and (list-or-array? a) (list-or-array? b))
         (and (= (length a) (length b))
              (for/and ((x a) (y b)) (same? x y))))
        (else (equal? a b))))

;;; A product of numbers, vectors or matrices.
(define (times a b)
  (if (or (number? a) (number? b))
    (* a b)
    (@ (array a) (array b))))

;;; Whether a value is a list in OpenSCAD.
(define (list-or-array? x)
  (or (list? x) (vector? x) (matrix? x) (array? x)))

;;; The cross product of two vectors: a number if they have two components.
(define (cross-of a b)
  (if (= (length a) 2)
    (determinant [a b])
    (cross a b)))

;;; A number rounded, halves away from zero.
(define (rounded-number x)
  (if (< x 0)
    (- (floor (+ (- x) .5)))
    (floor (+ x .5))))

;;; A value as `str` of OpenSCAD shows it.
(define (shown x)
  (cond ((number? x) (format "{:g}" x))
        ((string? x) x)
        ((none? x) "undef")
        ((boolean? x) (if x "true" "false"))
        (else (string-append "[" (string-join (map shown (->list x)) ", ") "]"))))

;;; The value of a table of pairs [key value] at `key`, by linear interpolation.
(define (lookup key rows)
  (define sorted (sort (->list rows) (lambda (a b) (< (first a) (first b)))))
  (interp key (map first sorted) (map second sorted)))
"""


def _by_name(text: str) -> dict[str, str]:
    blocks = {}
    for block in text.strip().split("\n\n"):
        match = re.search(r"^\(define \((\S+)", block, re.MULTILINE)
        assert match is not None, block
        blocks[match[1].rstrip(")")] = block
    return blocks


HELPERS = _by_name(_TEXT)
