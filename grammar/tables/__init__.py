"""Tables of the parsers: one module for each grammar, which ``make tables`` writes.

They are Python, whose bytecode is read in a sixth of the time that JSON takes. Nothing here is written by hand, and
nothing here imports anything; ``grammar/table_making`` makes them with Lark.
"""
