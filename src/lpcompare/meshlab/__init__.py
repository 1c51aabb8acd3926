"""lpcompare inside pymeshlab: filters on `pymeshlab.MeshSet` that look and behave like MeshLab's own.

>>> import lpcompare.meshlab
>>> lpcompare.meshlab.install()

binds them as methods; `apply_filter` calls them without binding anything. `save_filter_script` and
`apply_filter_script` record and replay filter scripts that mix MeshLab's filters with these.
"""

from lpcompare.meshlab.application import apply_filter, filter_list, print_filter_parameter_list
from lpcompare.meshlab.binding import install, uninstall
from lpcompare.meshlab.scripts import apply_filter_script, clear_filter_script, save_filter_script

__all__ = [
    "apply_filter",
    "apply_filter_script",
    "clear_filter_script",
    "filter_list",
    "install",
    "print_filter_parameter_list",
    "save_filter_script",
    "uninstall",
]
