"""A body of a world, in and out of other packages."""
import numpy as np

from . import _turgor
from .volume import Volume


class Body(_turgor.Body):
    """A body of a world as it is now, whenever it is asked. Arrays are copies, which nothing changes behind your back;
    those of `live` are views."""

    @property
    def live(self):
        """Views of the body's own memory: no copy, and what the next step changes is seen in them. They keep the world."""
        return _turgor.live_of(self)

    def volume(self):
        """lattice: the Volume that it is made of."""
        return Volume(*self._volume())

    def deformed_volume(self):
        """lattice: the Volume as it would be scanned now, on the same grid."""
        return Volume(*self._deformed_volume())

    def to_pyvista(self):
        """A pyvista.PolyData of the surface as it lies now, with what is known at its points."""
        import pyvista

        faces = np.column_stack([np.full(len(self.triangles), 3, dtype=np.int64), self.triangles])
        mesh = pyvista.PolyData(self.points, faces.ravel())
        for name, unit in (("displacement", " [m]"), ("normals", ""), ("pressure", " [Pa]"), ("stretch", "")):
            values = getattr(self, name)
            if len(values):
                mesh.point_data[name + unit] = values
        return mesh

    def to_trimesh(self):
        """A trimesh.Trimesh of the surface as it lies now, vertex by vertex."""
        import trimesh

        return trimesh.Trimesh(vertices=self.points, faces=self.triangles, process=False)
