"""The computation graph of a scene as a drawing."""
