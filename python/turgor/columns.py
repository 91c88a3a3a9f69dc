"""Tables as columns."""
from __future__ import annotations

from typing import TYPE_CHECKING, Any, Dict

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import pandas


class Columns(Dict[str, NDArray[Any]]):
    """NumPy arrays of equal length by name; names end in their unit. Vector columns have the shape (n, 3)."""

    def frame(self) -> pandas.DataFrame:
        """A pandas.DataFrame; (n, 3) columns become three, as force_x_N."""
        import pandas

        flat = {}
        for name, column in self.items():
            if np.ndim(column) == 1:
                flat[name] = column
                continue
            stem, _, unit = name.rpartition("_")
            for axis, values in zip("xyz", np.transpose(column)):
                flat[f"{stem}_{axis}_{unit}"] = values
        return pandas.DataFrame(flat)
