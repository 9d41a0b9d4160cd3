"""The checker: a program as a unit, the kinds of its expressions, and lints, before anything runs.

``program`` expands files in order to top-level forms. ``kinds`` is the lattice of kinds, ``builtins`` has results of
library functions, ``calls`` checks calls against signatures, ``infer`` walks forms and ``book`` keeps results between
versions. ``rules`` has the lints of one form, ``lint`` those of the whole program; ``habits``, ``idioms`` and
``other_tools`` know other languages and tools, ``angles`` a name of earlier versions. Nothing here evaluates a program.
"""
