"""Completion of command lines in shells: scripts written from the parser that the commands use."""
