"""`scenelang view`: shows programs in a browser, watches their files, writes params back (docs/viewer.md).

``workspace`` is the state of what is shown, ``server`` answers the page. What the page draws is ``backends.viewer``.
"""
