"""Static inference of kinds: which kinds of values each expression of the core AST can have, before it runs.

``kinds`` is the lattice, ``builtins`` knows the results of library functions, ``calls`` checks calls against
signatures, ``infer`` walks the forms of a program and ``book`` keeps results between versions. Nothing here evaluates a
program or knows an application.
"""
