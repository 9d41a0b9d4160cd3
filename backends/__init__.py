"""From the entity DAG to pictures and meshes: rendering operations, found by name (see ``base``)."""
