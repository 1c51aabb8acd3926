"""Point clouds from and to files."""
