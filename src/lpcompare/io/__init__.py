"""Point clouds from files and back, with everything that their format says about each point."""

from lpcompare.io.formats import (
    check_target,
    keep_rows,
    left_out,
    read_point_cloud,
    same_format,
    write_point_cloud,
)

__all__ = ["check_target", "keep_rows", "left_out", "read_point_cloud", "same_format", "write_point_cloud"]
