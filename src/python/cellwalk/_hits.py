# SPDX-License-Identifier: Apache-2.0
"""Answers of Field.closest."""

from __future__ import annotations

import numpy as np

_dtype = np.dtype({"names": ["t", "u", "v", "i", "j", "triangle"], "formats": ["=f4", "=f4", "=f4", "=i4", "=i4", "=u4"],
                   "offsets": [0, 16, 20, 4, 8, 12], "itemsize": 24})  # as cw_hit of include/cellwalk.h


class Hits:
    """Where rays hit; every member has the shape of the rays.

    hit       bool: whether the ray hits at all
    t         float32: the hit is at origin + t * direction; inf on a miss
    i, j      int32: column and row of the cell; -1 on a miss
    triangle  uint32: 0 below the cell's diagonal from (i, j) to (i + 1, j + 1), 1 above
    u, v      float32: place on the triangle p0 p1 p2, p0 + u (p1 - p0) + v (p2 - p0); its vertices are (i, j), (i + 1, j),
              (i + 1, j + 1) below the diagonal and (i, j), (i + 1, j + 1), (i, j + 1) above
    records   the same as one structured array

    Members are views of `records`; nothing is copied. hits[index] is the hits at that index.

        >>> import numpy as np, cellwalk as cw
        >>> f = cw.Field(np.zeros((5, 5), "float32"))
        >>> h = f.closest([[1.5, 1.25, 9], [7, 7, 9]], [0, 0, -1])
        >>> h.hit, h.t
        (array([ True, False]), array([ 9., inf], dtype=float32))
        >>> h[h.hit].points()
        array([[1.5 , 1.25, 0.  ]])
    """

    __slots__ = ("records", "_field")
    t: np.ndarray
    u: np.ndarray
    v: np.ndarray
    i: np.ndarray
    j: np.ndarray
    triangle: np.ndarray

    def __init__(self, records: np.ndarray, field) -> None:
        self.records = records
        self._field = field

    @property
    def hit(self) -> np.ndarray:
        return self.records["i"] >= 0

    @property
    def shape(self) -> tuple[int, ...]:
        return self.records.shape

    def __len__(self) -> int:
        return len(self.records)

    def __getitem__(self, index) -> "Hits":
        return Hits(np.asarray(self.records[index]), self._field)

    def __repr__(self) -> str:
        return f"<cellwalk.Hits: {int(self.hit.sum())} of {self.records.size} rays hit, shape {self.shape}>"

    def points(self, *, progress=None) -> np.ndarray:
        """Places of the hits on the surface: float64, shape (..., 3), x, y, z of the map; NaN on a miss.

        They lie on the triangle to rounding, unlike origin + t * direction.
        """
        return self._follow(0, progress)

    def normals(self, smooth: bool = False, *, progress=None) -> np.ndarray:
        """Unit normals on the upper side: float64, shape (..., 3); NaN on a miss.

        smooth: normals interpolated over the triangle from those at the samples, instead of the triangle's own.
        """
        return self._follow(2 if smooth else 1, progress)

    def _follow(self, kind: int, progress) -> np.ndarray:
        records = np.ascontiguousarray(self.records)
        out = np.empty(self.shape + (3,), np.float64)
        if records.size:
            self._field._call("normals" if kind else "points", {"kind": kind}, (records.view(np.uint8),), (out,), progress, core=self._field._core)
        return out


for _name in _dtype.names:
    setattr(Hits, _name, property(lambda self, name=_name: self.records[name]))
