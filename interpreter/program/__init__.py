"""Programs as units: files, imports, top-level forms and params.

``program`` expands files in order; ``interactive`` maintains a REPL session and a program under edit. Both handle the
text of forms, not their evaluation.
"""
