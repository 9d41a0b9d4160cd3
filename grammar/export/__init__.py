"""The grammar as text for other programs: decoders of language models, parser generators, editors, people.

``model`` is the grammar as data, ``spacing`` says where white space may stand; ``lark_text``, ``gbnf``, ``ebnf`` and
``textmate`` write. It knows no builtin: names of the library are handed in.
"""
