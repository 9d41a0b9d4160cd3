"""Export of the grammar as text, for constrained decoding, parser generators, editors and people.

``model`` represents the grammar as data, ``spacing`` makes white space explicit; ``lark_text``, ``gbnf``, ``ebnf`` and
``textmate`` write it. Names of the standard library are passed in; this package knows no builtin.
"""
