"""NRRD files of CTs. The header stores the pose of the volume as text with full precision. read() supports files of Turgor."""
import gzip
import re

import numpy as np


def write(file, samples, affine):
    """Writes samples (k, j, i) as int16. affine: (4, 4), from (i, j, k, 1) to LPS [mm]."""

    def vector(numbers):
        return "(" + ",".join(repr(float(n)) for n in numbers) + ")"

    k, j, i = samples.shape
    directions = " ".join(vector(affine[:3, axis]) for axis in range(3))
    header = (f"NRRD0004\ntype: int16\ndimension: 3\nspace: left-posterior-superior\nsizes: {i} {j} {k}\n"
              f"space directions: {directions}\nkinds: domain domain domain\nendian: little\nencoding: raw\n"
              f"space origin: {vector(affine[:3, 3])}\n\n")
    with open(file, "wb") as out:
        out.write(header.encode("ascii"))
        out.write(np.ascontiguousarray(samples, dtype="<i2").data)


def read(file):
    """Returns samples (k, j, i) and affine, as for write()."""
    with open(file, "rb") as given:
        header, _, body = given.read().partition(b"\n\n")
    fields = dict(line.split(": ", 1) for line in header.decode("ascii").splitlines() if ": " in line and line[0] != "#")
    if fields["encoding"] == "gzip":
        body = gzip.decompress(body)
    i, j, k = map(int, fields["sizes"].split())
    affine = np.eye(4)
    directions = re.findall(r"\(([^)]*)\)", fields["space directions"])
    affine[:3, :3] = np.array([d.split(",") for d in directions], dtype=float).T
    affine[:3, 3] = np.array(fields["space origin"].strip("()").split(","), dtype=float)
    return np.frombuffer(body, dtype="<i2").reshape(k, j, i), affine
