"""From the entity graph to pictures, labels, files and builds.

``base`` says what a backend is and finds those that packages add; ``files`` writes output whole or not at all. Each
folder is one kind of result. Backends are given a scene: they do not read programs, and nothing here knows of commands,
servers or notebooks.
"""
