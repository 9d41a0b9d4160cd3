"""The REPL: a session that goes on, in a terminal or driven by another program."""
