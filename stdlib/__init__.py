"""What programs can call: one file for each topic, and modules in the language (``*.scene``).

An entry is registered once, with signature, types, doc and example; ``library`` collects the topics, ``reference``
turns them into documentation, ``grammars`` into grammars; ``operands`` is what topics share. It draws and writes
nothing.
"""
