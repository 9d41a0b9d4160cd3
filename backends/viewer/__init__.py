"""Content of the live viewer (docs/viewer.md).

``packet`` serializes a scene as compact binary data; ``page`` provides the built page, served or as a single file,
whose source is in ``source``. Serving pages and watching files is the task of ``scenelang.viewer``.
"""
