# SPDX-License-Identifier: Apache-2.0
"""Exact ray queries on height fields: terrain, elevation models, seas.

    >>> import numpy as np, cellwalk as cw
    >>> z = np.zeros((3, 3), np.float32); z[1, 1] = 4          # a peak; z[j, i] stands at x = i, y = j
    >>> f = cw.Field(z)
    >>> h = f.closest([-1, 1.25, 2], [1, 0, 0])
    >>> bool(h.hit), round(float(h.t), 4), int(h.i), int(h.j)
    (True, 1.75, 0, 1)

Make a field with Field(array) or open(file). Then ask it:

    closest, occluded where rays hit, or whether they do
    at                the surface's height at places
    shadow            sun and shadow on every sample
    insolation        hours of sun on every sample, or the energy of its light
    viewshed, sites   which samples are seen from places, how many from each
    visibility        how much of the ground every sample sees
    horizon, sky_view the horizon's angle all round, the share of the sky
    sun_days          the sun at one place: rise, set, hours, energy
    horizon_at        the horizon as a place sees it
    openness          how open the land is, upward or downward
    line_of_sight     whether two places see each other, and the clearance of a radio link; profile
    update            new heights in a rectangle
    coarser           a field of every n-th sample, with its error

cellwalk.sun says where the sun stands, cellwalk.kernels which ways of tracing there are. cellwalk.dask has shadow,
insolation, viewshed, visibility, horizon, sky_view and openness of rasters larger than memory.

Places are those of the map: x and y by `transform` or by the coordinates of a DataArray. Without a map, x is the
column and y the row, and azimuths take the first row for the north, as in a picture. Arrays of samples are indexed
[row, column]. Results are of the caller's kind: a DataArray in, a DataArray out.

All answers are exact for the surface of two triangles between each four samples. They are the same bits for any
number of threads, any CPU, and the program `cellwalk`.
"""

from ._core import version as __version__
from ._field import Difference, Field, open
from ._light import SunDays, sun
from ._rays import Hits, kernels
from ._sight import LineOfSight, PlaceHorizon, Profile, Sites
from . import _xarray  # noqa: F401  (registers DataArray.cellwalk if xarray is loaded later or already)

__all__ = ["Difference", "Field", "Hits", "LineOfSight", "PlaceHorizon", "Profile", "Sites", "SunDays", "kernels", "open", "sun", "__version__"]
