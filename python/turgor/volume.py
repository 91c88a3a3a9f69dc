"""Volumes in the patient frame, with conversions from and to SimpleITK and nibabel."""
from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._turgor import Error

if TYPE_CHECKING:
    import nibabel
    import SimpleITK

_RAS = np.diag([-1.0, -1.0, 1.0])  # between LPS and RAS


class Volume:
    """Samples on a regular grid in the patient frame: LPS (x to the left, y to the back, z to the head), in meters.

    samples: (k, j, i), i fastest. Hounsfield units for a CT, whole numbers from 0 for a segmentation.
    spacing: (3,) between samples along i, j, k [m].
    origin: (3,) position of sample (0, 0, 0) [m].
    axes: (3, 3), orthonormal; its columns are the directions of i, j, k, which may be oblique.
    """

    def __init__(self, samples: ArrayLike, spacing: ArrayLike, origin: ArrayLike = (0, 0, 0),
                 axes: ArrayLike = ((1, 0, 0), (0, 1, 0), (0, 0, 1))) -> None:
        self.samples: NDArray[Any] = np.asarray(samples)
        self.spacing = np.array(spacing, dtype=np.float64)
        self.origin = np.array(origin, dtype=np.float64)
        self.axes = np.array(axes, dtype=np.float64)
        self._check()

    def _check(self):
        if self.samples.ndim != 3 or 0 in self.samples.shape:
            raise Error(f"a volume: expected samples (k, j, i), found an array of {self.samples.shape}")
        for name, shape in (("spacing", (3,)), ("origin", (3,)), ("axes", (3, 3))):
            array = getattr(self, name)
            if array.shape != shape or not np.isfinite(array).all():
                raise Error(f"a volume's {name}: expected {shape} finite numbers, found {array.tolist()}")
        if not (self.spacing > 0).all():
            raise Error(f"a volume's spacing: expected lengths above 0 [m], found {self.spacing.tolist()}")
        skew = np.abs(self.axes.T @ self.axes - np.eye(3)).max()
        if skew > 1e-3:
            raise Error(f"a volume's axes: expected unit directions square to each other, found some that are {skew:.2g} off")

    @property
    def affine(self) -> NDArray[np.float64]:
        """(4, 4): matrix from an index (i, j, k, 1) to a position [m, LPS]."""
        matrix = np.eye(4)
        matrix[:3, :3] = self.axes * self.spacing
        matrix[:3, 3] = self.origin
        return matrix

    @classmethod
    def from_affine(cls, samples: ArrayLike, affine: ArrayLike) -> Volume:
        """Volume from samples (k, j, i) and the (4, 4) matrix from (i, j, k, 1) to positions [m, LPS]."""
        affine = np.asarray(affine, dtype=np.float64)
        spacing = np.linalg.norm(affine[:3, :3], axis=0)
        if not (spacing > 0).all():
            raise Error(f"a volume's affine: expected a spacing along each axis, found {spacing.tolist()} m")
        return cls(samples, spacing, affine[:3, 3], affine[:3, :3] / spacing)

    @classmethod
    def from_sitk(cls, image: SimpleITK.Image) -> Volume:
        """Volume from a three-dimensional SimpleITK image, whose unit is mm."""
        import SimpleITK as sitk

        axes = np.array(image.GetDirection()).reshape(3, 3) if image.GetDimension() == 3 else np.zeros((3, 3))
        return cls(sitk.GetArrayFromImage(image), np.array(image.GetSpacing()) * 1e-3, np.array(image.GetOrigin()) * 1e-3, axes)

    def to_sitk(self) -> SimpleITK.Image:
        import SimpleITK as sitk

        image = sitk.GetImageFromArray(np.ascontiguousarray(self.samples))
        image.SetSpacing((self.spacing * 1e3).tolist())
        image.SetOrigin((self.origin * 1e3).tolist())
        image.SetDirection(self.axes.ravel().tolist())
        return image

    @classmethod
    def from_nibabel(cls, image: nibabel.Nifti1Image) -> Volume:
        """Volume from a three-dimensional nibabel image, in mm and RAS; sheared images are refused."""
        affine = np.array(image.affine, dtype=np.float64)
        affine[:3] = _RAS @ affine[:3] * 1e-3
        return cls.from_affine(np.asanyarray(image.dataobj).T, affine)

    def to_nibabel(self) -> nibabel.Nifti1Image:
        import nibabel

        affine = self.affine
        affine[:3] = _RAS @ affine[:3] * 1e3
        return nibabel.Nifti1Image(np.ascontiguousarray(self.samples).T, affine)

    def _fields(self, samples):
        return np.ascontiguousarray(samples), self.spacing.tolist(), self.origin.tolist(), self.axes.ravel().tolist()

    def _as_ct(self):
        """Samples in Hounsfield units, rounded and clamped to int16; NaN becomes air."""
        values = self.samples
        if values.dtype != np.int16:
            if not np.issubdtype(values.dtype, np.integer):
                values = np.rint(np.nan_to_num(values.astype(np.float64), nan=-1000))
            values = np.clip(values, -32768, 32767).astype(np.int16)
        return self._fields(values)

    def _as_labels(self):
        values = self.samples
        whole = values.astype(np.uint16)
        if not (whole == values).all():
            raise Error("a segmentation: expected whole numbers from 0 to 65535, found others")
        return self._fields(whole)

    def __repr__(self) -> str:
        k, j, i = self.samples.shape
        return f"Volume({i}×{j}×{k} of {self.samples.dtype}, spacing {np.round(self.spacing * 1e3, 3).tolist()} mm)"
