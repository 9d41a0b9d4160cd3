"""Datums to core forms: special forms, derived forms, macros and hygiene. Knows nothing of values at run time."""
