# SPDX-License-Identifier: Apache-2.0
"""dem.cellwalk, where xarray is installed."""

from __future__ import annotations

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


def _forward(name: str):
    from ._products import Products

    def call(self, *arguments, **keywords):
        return getattr(self.field(), name)(*arguments, **keywords)

    call.__name__, call.__doc__ = name, getattr(Products, name).__doc__
    return call


for _name in ("shadow", "viewshed", "horizon", "sky_view", "openness", "visibility", "insolation", "sun_days", "line_of_sight", "profile", "horizon_at", "sites", "sun"):
    setattr(Accessor, _name, _forward(_name))

if xarray is not None and not hasattr(xarray.DataArray, "cellwalk"):
    xarray.register_dataarray_accessor("cellwalk")(Accessor)
