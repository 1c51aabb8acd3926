"""Point clouds from files and back, with everything that their format says about each point."""

from lpcompare.io.formats import check_target, keep_rows, read, same_format, write

__all__ = ["check_target", "keep_rows", "read", "same_format", "write"]
