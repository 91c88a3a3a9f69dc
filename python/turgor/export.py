"""Recordings as files for other programs: python -m turgor.export out/palpation/recording.h5 palpation.usda [palpation.glb ...]

Endings: .usda (text), .usdc, .usd and .usdz (binary, with usd-core), .glb (glTF 2.0).
"""
import argparse
import pathlib
import sys

from ._turgor import Error
from .recording import Recording, export_gltf, export_usd


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="python -m turgor.export", description="Writes a recording as USD or glTF.")
    parser.add_argument("recording", help="recording.h5 of a run")
    parser.add_argument("files", nargs="+", help="files to write; their endings choose the format: .usda .usdc .usd .usdz .glb")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="as for turgor run --replay, such as body.torso.ct=FILE")
    given = parser.parse_args(arguments)
    try:
        recording = Recording(given.recording, set=dict(pair.partition("=")[::2] for pair in given.set))
        for file in given.files:
            (export_gltf if pathlib.Path(file).suffix == ".glb" else export_usd)(recording, file)
            print(f"{file}: {len(recording)} snapshots")
    except (Error, OSError) as error:
        print(f"turgor.export: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
