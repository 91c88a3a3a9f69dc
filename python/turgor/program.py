"""The command `turgor` of a wheel that has the program: `turgor run SCENE`, or `python -m turgor.program run SCENE`."""
import os
import pathlib
import sys


def main():
    """Replaces this process by the program. Raises SystemExit with a sentence in a wheel without it."""
    program = pathlib.Path(__file__).parent / "bin/turgor"
    if not program.exists():
        sys.exit(f"turgor: this wheel has no program, expected {program}; the full wheel has it (docs/python.md)")
    os.execv(program, ["turgor", *sys.argv[1:]])


if __name__ == "__main__":
    main()
