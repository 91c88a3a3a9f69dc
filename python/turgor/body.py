"""A body of a world, with conversions to other packages."""
from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from . import _turgor
from .volume import Volume

if TYPE_CHECKING:
    import pyvista
    import trimesh


class Body(_turgor.Body):
    """A body of a world in its present state. Arrays are copies; those of `live` are views."""

    def __repr__(self) -> str:
        return f"<turgor.Body {self.name}: {self.model}>"

    @property
    def live(self) -> _turgor.LiveBody:
        """Zero-copy views of the body's memory, which show later changes and keep the world alive."""
        return _turgor.live_of(self)

    def volume(self) -> Volume:
        """lattice: the Volume from which the body was built.

        It has the samples and the grid of a Volume in memory. The grid of a file is right-handed: samples of a left-handed
        file are in the opposite order along i, at the same positions.
        """
        return Volume(*self._volume())

    def deformed_volume(self) -> Volume:
        """lattice: the Volume in the deformed state, on the grid of volume()."""
        return Volume(*self._deformed_volume())

    def to_pyvista(self) -> pyvista.PolyData:
        """A pyvista.PolyData of the present surface, with its point data."""
        import pyvista

        faces = np.column_stack([np.full(len(self.triangles), 3, dtype=np.int64), self.triangles])
        mesh = pyvista.PolyData(self.points, faces.ravel())
        for name, unit in (("displacement", " [m]"), ("normals", ""), ("pressure", " [Pa]"), ("stretch", "")):
            values = getattr(self, name)
            if len(values):
                mesh.point_data[name + unit] = values
        return mesh

    def to_trimesh(self) -> trimesh.Trimesh:
        """A trimesh.Trimesh of the present surface, with the same vertices."""
        import trimesh

        return trimesh.Trimesh(vertices=self.points, faces=self.triangles, process=False)
