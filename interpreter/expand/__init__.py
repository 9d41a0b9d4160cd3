"""Macro expander from datums to core forms: special forms, derived forms, user-defined macros and hygiene.

``forms`` is the table of special forms, ``expand`` the traversal, ``derived`` the forms defined in terms of others,
``macros`` user-defined macros, ``scope`` name resolution. ``expand`` and ``derived`` import each other because they
recurse on the same tree. Nothing here depends on runtime values.
"""
