"""Tables as columns."""
import numpy as np


class Columns(dict):
    """NumPy arrays by name, a row each of the same length; names end in their unit. Those of three numbers a row are (n, 3)."""

    def frame(self):
        """A pandas.DataFrame; (n, 3) columns become three, as force_x_N."""
        import pandas

        flat = {}
        for name, column in self.items():
            if np.ndim(column) == 1:
                flat[name] = column
                continue
            stem, _, unit = name.rpartition("_")
            for axis, part in zip("xyz", np.transpose(column)):
                flat[f"{stem}_{axis}_{unit}"] = part
        return pandas.DataFrame(flat)
