"""Static analysis of the Python code, which completes before any code is generated.

``scopes`` resolves names, ``infer`` with ``expressions``, ``inference`` and ``known`` infers types, ``liveness``
computes live variables and closure captures, and ``collect`` finds lists that can become comprehensions.
"""
