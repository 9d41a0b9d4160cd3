"""What the Python means, found out before a word is written.

``collect`` and ``scopes`` find names, ``infer`` with ``expressions``, ``inference`` and ``known`` finds types,
``liveness`` what is read later. It writes nothing.
"""
