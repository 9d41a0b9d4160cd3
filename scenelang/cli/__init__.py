"""The command line: each command parses its arguments, makes one call of the API, and prints the result.

``main`` runs it, ``commands`` is the table, ``options`` makes arguments of classes of settings, ``output``
prints; the other files have the commands by subject. Nothing outside imports from here.
"""
