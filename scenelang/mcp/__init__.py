"""The server of the Model Context Protocol: an agent checks, runs, measures, draws and compares (docs/mcp.md).

``tools`` has the tools as functions, ``server`` offers them. Programs run in the sandbox's worker.
"""
