"""Core AST to running code: analysis of variables, closures, fast paths; and core AST back to text."""
