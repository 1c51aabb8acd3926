"""The rivals: one file per method, one function of the file's name."""
