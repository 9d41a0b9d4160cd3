"""Exports: scenes as files for other programs (docs/exports.md)."""
