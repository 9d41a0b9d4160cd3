"""Hard limits: untrusted programs are evaluated in processes of their own, which a parent watches and ends.

``supervision`` runs a command in a child under a monitor, ``worker`` serves requests by children, ``status`` is the
page of memory that monitor and child share, ``confinement`` takes files, sockets and new programs from the thread that
evaluates. The package knows nothing of commands, protocols or pictures (docs/security.md).
"""
