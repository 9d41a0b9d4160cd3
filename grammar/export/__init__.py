"""Export of the grammar as text, for constrained decoding, parser generators, editors and people.

``model`` represents the grammar as data, ``spacing`` makes white space explicit, ``notations`` writes it as text. Names
of the standard library are passed in; this package knows no builtin.
"""
