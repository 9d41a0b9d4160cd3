"""Searches that edit a program, evaluate it and keep what helps.

``alternatives`` tests fixes of the checker, ``repairing`` resolves findings and declarations, ``instance_edits``
changes instances, ``checking`` joins all checks. They edit texts through sessions, and know no command.
"""
