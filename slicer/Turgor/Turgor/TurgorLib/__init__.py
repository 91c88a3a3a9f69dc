"""What the module Turgor of 3D Slicer is made of, apart from Slicer itself."""
