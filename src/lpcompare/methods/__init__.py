"""The project's own methods in the form that the harness calls: one file, one function of its name."""
