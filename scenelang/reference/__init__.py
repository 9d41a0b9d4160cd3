"""The reference of the language as data.

``primer`` is what prompts and help say, ``searching`` finds entries by meaning, ``highlight`` colors programs. All of
it comes from the registered builtins, forms and primitives.
"""
