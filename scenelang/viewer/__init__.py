"""`scenelang view`: live view of programs in a browser, with file watching and editable params (docs/viewer.md).

``workspace`` is the state of the view, ``server`` the HTTP server. Rendering in the page is in ``backends.viewer``.
"""
