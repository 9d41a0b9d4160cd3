"""The server of the Model Context Protocol: an agent checks, runs, measures, draws and compares scenes."""
