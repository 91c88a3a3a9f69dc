"""The picture of docs/paraview.md: pvbatch docs/pictures/in-paraview.py out/palpation docs/pictures/paraview.png"""
import sys

from paraview.simple import *

run, picture = sys.argv[1], sys.argv[2]
series = PVDReader(FileName=run + "/meshes.pvd")  # bodies, tools and forces on these, a block each
view = CreateView("RenderView")
view.ViewSize, view.Background, view.UseColorPaletteForBackground = [720, 480], [1, 1, 1], 0
view.OrientationAxesVisibility = 0
view.ViewTime = 1.0  # s

liver = Show(ExtractBlock(Input=series, Selectors=["/Root/liver"]), view)
ColorBy(liver, ("POINTS", "displacement [m]", "Magnitude"))
colors = GetColorTransferFunction("displacement [m]")
colors.RescaleTransferFunction(0, 0.006)
bar = GetScalarBar(colors, view)
bar.Title, bar.ComponentTitle = "displacement [m]", ""
bar.TitleColor = bar.LabelColor = [0, 0, 0]
liver.SetScalarBarVisibility(view, True)

finger = Show(ExtractBlock(Input=series, Selectors=["/Root/finger"]), view)
finger.ColorArrayName = ["POINTS", ""]
finger.DiffuseColor, finger.Opacity = [0.3, 0.3, 0.35], 0.5

forces = Glyph(Input=ExtractBlock(Input=series, Selectors=["/Root/forcesontools"]), GlyphType="Arrow")
forces.OrientationArray = ["POINTS", "force on the tool [N]"]
forces.ScaleArray = ["POINTS", "force on the tool [N]"]
forces.ScaleFactor = 0.3  # meters a newton
arrow = Show(forces, view)
arrow.ColorArrayName = ["POINTS", ""]
arrow.DiffuseColor = [0.1, 0.5, 0.1]

view.CameraPosition, view.CameraFocalPoint, view.CameraViewUp = [-0.15, -1, 0.4], [0, 0, 0], [0, 0, 1]
view.ResetCamera()
GetActiveCamera().Dolly(1.45)
SaveScreenshot(picture, view)
