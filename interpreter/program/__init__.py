"""A program's files, imports, top-level forms and params; versions of a program that is being edited."""
