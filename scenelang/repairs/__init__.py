"""Searches that edit a program, evaluate it and keep what helps.

``alternatives`` tests fixes of the checker, ``repairing`` resolves findings and declarations, ``instance_edits``
changes instances: ``placing_numbers`` finds the numbers behind a pose, ``single_instances`` makes exceptions. All edit
texts through sessions, and know no command.
"""
