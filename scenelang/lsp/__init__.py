"""The language server: what editors ask about programs, answered by a session (docs/editors.md)."""
