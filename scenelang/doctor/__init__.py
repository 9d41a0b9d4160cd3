"""Check of the installation: a quick test of every feature in a separate process.

As the command line, it names all domains, imports each in the function that tests it, and runs without any of them.
"""
