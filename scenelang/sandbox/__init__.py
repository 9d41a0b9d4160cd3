"""Hard limits: untrusted programs are evaluated in child processes that the parent monitors and kills if necessary.

``supervision`` runs a command in a child under a monitor, ``worker`` runs requests in children, ``status`` is the
memory page shared by monitor and child, ``confinement`` removes access to files, sockets and programs from the
evaluating thread. The package does not depend on commands, protocols or rendering (docs/security.md).
"""
