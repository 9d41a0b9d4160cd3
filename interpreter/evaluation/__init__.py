"""Running programs that the checker has passed.

``evaluate`` runs a program once, ``interactive`` continues the run of an earlier version of it, as editors and the
REPL do. Nothing here knows what becomes of the entity graph.
"""
