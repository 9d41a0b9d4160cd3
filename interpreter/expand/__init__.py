"""Datums to core forms: special forms, derived forms, macros, hygiene.

``forms`` is the table of special forms, ``expand`` the walk, ``derived`` the forms that become others, ``macros`` those
of users, ``scope`` which name means what. ``expand`` and ``derived`` import each other: they recurse on the same tree.
It knows nothing of values at run time.
"""
