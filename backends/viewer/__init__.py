"""What the live viewer shows (docs/viewer.md).

``packet`` is a scene as compact data, ``page`` the built page, served or as one file; its source is in ``source``. It
serves nothing and watches nothing: that is ``scenelang.viewer``.
"""
