"""Model Context Protocol server: agents check, run, measure, render and compare programs (docs/mcp.md).

``tools`` implements the tools as functions, ``server`` exposes them. Programs run in the sandbox's worker.
"""
