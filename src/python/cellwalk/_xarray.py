# SPDX-License-Identifier: Apache-2.0
"""dem.cellwalk, where xarray is installed."""

from __future__ import annotations

import functools

from ._light import Light
from ._sight import Sight

try:
    import xarray
except ImportError:
    xarray = None  # type: ignore[assignment]


class Accessor:
    """cellwalk's products of a DataArray with dimensions (y, x):

        dem.cellwalk.shadow(azimuth=225, altitude=30)
        dem.cellwalk.viewshed(600250, 5199800)

    Each call makes a field anew, since the array may have changed. For rays or many products keep one: dem.cellwalk.field().
    """

    def __init__(self, array) -> None:
        self._array = array

    def field(self, **arguments):
        """cellwalk.Field(dem, **arguments)"""
        from ._field import Field
        return Field(self._array, **arguments)


def _forward(name: str, method):
    @functools.wraps(method)
    def call(self, *arguments, **keywords):
        return getattr(self.field(), name)(*arguments, **keywords)
    return call


for _class in Light, Sight:
    for _name, _method in vars(_class).items():
        if not _name.startswith("_"):
            setattr(Accessor, _name, _forward(_name, _method))

if xarray is not None and not hasattr(xarray.DataArray, "cellwalk"):
    xarray.register_dataarray_accessor("cellwalk")(Accessor)
