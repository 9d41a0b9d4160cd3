"""Libraries that people import beside Python's own and numpy, for the evaluator.

Noise and rotations are computed by this package; the other libraries by themselves, on numbers, texts, lists and
arrays, as far as the tables of ``scientific`` name them. Nothing else of a library can be reached.
"""
