"""Command-line interface: each command parses its arguments, calls the API, and prints the result.

``main`` runs it, ``commands`` is the table of commands, ``options`` what they share;
the other modules implement the commands by subject. No other package imports this one.
"""
