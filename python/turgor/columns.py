"""Tables as columns."""
from __future__ import annotations

from typing import TYPE_CHECKING, Any, Dict, Literal, overload

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import pandas


class Columns(Dict[str, NDArray[Any]]):
    """NumPy arrays of equal length by name; names end in their unit. Vector columns have the shape (n, 3), quaternions (n, 4)."""

    if TYPE_CHECKING:  # counts are whole numbers, every other column has float64

        @overload  # type: ignore[override]
        def __getitem__(self, name: Literal["contacts", "bearing", "sliding"], /) -> NDArray[np.intc]: ...
        @overload
        def __getitem__(self, name: str, /) -> NDArray[np.float64]: ...

    def frame(self) -> pandas.DataFrame:
        """A pandas.DataFrame; (n, 3) columns become three, as force_x_N, and a quaternion four, as rotation_w."""
        import pandas

        flat = {}
        for name, column in self.items():
            if np.ndim(column) == 1:
                flat[name] = column
                continue
            if column.shape[1] == 4:
                flat.update((f"{name}_{axis}", values) for axis, values in zip("wxyz", np.transpose(column)))
                continue
            stem, _, unit = name.partition("_")
            for axis, values in zip("xyz", np.transpose(column)):
                flat[f"{stem}_{axis}_{unit}"] = values
        return pandas.DataFrame(flat)
