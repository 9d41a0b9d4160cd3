"""The semantics of programs: expansion, compilation, evaluation, the entity graph and its geometry.

A program passes through ``program``, ``expand``, ``compile`` and ``runtime``, and results in a graph of ``scene``.
``lint`` finds likely mistakes before a program runs; ``transpile`` converts Python written by a language model. The
standard library is supplied through an interface (``runtime.types.Library``); nothing here imports ``stdlib`` or a
backend.
"""
