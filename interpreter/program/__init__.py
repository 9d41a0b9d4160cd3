"""Programs as users write them: files, imports, top-level forms, params.

``program`` expands files in order, ``interactive`` keeps a session of forms and a program under edit. It knows the text
of forms and not what they do when they run.
"""
