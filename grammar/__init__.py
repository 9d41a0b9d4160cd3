"""Text <-> trees: reader, core grammar, printer, diagnostics. Knows nothing of what programs mean."""
