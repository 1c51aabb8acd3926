"""Point clouds from files and back, with everything that their format says about each point."""

from lpcompare.io.formats import keep_rows, read_point_cloud, write_point_cloud

__all__ = ["keep_rows", "read_point_cloud", "write_point_cloud"]
