"""Code of the Turgor module for 3D Slicer that does not depend on Slicer."""
