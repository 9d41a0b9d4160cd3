"""What programs can call: builtins by topic, and modules written in the language."""
