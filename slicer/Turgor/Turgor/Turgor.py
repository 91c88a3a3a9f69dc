"""Turgor in 3D Slicer: a volume, a line on its skin, a button; the wound, the deformed volume and its measures come back.

Here is what is Slicer's: the panel, and nodes of the scene in and out. The cut itself is TurgorLib.cut, in another process.
"""
import dataclasses
import shutil
import time

import ctk
import numpy as np
import qt
import slicer
import vtk
from slicer.ScriptedLoadableModule import ScriptedLoadableModule, ScriptedLoadableModuleLogic, ScriptedLoadableModuleWidget
from slicer.util import VTKObservationMixin
from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray

from TurgorLib.cut import Cut, CutError, Wishes, find_cutter, spread

CURVE_POINTS_APART = 5  # [mm]
SKIN, FLESH = (0.88, 0.67, 0.57), (0.65, 0.23, 0.2)


class Turgor(ScriptedLoadableModule):
    def __init__(self, parent):
        ScriptedLoadableModule.__init__(self, parent)
        self.parent.title = "Turgor"
        self.parent.categories = ["Simulation"]
        self.parent.dependencies = []
        self.parent.contributors = ["The authors of Turgor"]
        self.parent.helpText = ("Pick a CT, draw a line on its skin, press the button: a cut along the line opens under the "
                                "skin's tension. Wound, deformed volume and measures come back. Not a medical device.")


def matrix_of(vtk_matrix):
    return np.array([[vtk_matrix.GetElement(row, column) for column in range(4)] for row in range(4)])


def volume_to_world(volume):
    """(4, 4), from a volume's own RAS to the scene's; a volume that a transform bends or stretches is refused."""
    transform = volume.GetParentTransformNode()
    if transform is None:
        return np.eye(4)
    if not transform.IsTransformToWorldLinear():
        raise CutError("The volume lies under a transform that bends it: harden the transform first.")
    matrix = vtk.vtkMatrix4x4()
    transform.GetMatrixTransformToWorld(matrix)
    to_world = matrix_of(matrix)
    if np.abs(to_world[:3, :3].T @ to_world[:3, :3] - np.eye(3)).max() > 1e-3:
        raise CutError("The volume lies under a transform that stretches it: harden the transform first.")
    return to_world


def line_points(line):
    """(n, 3), world RAS [mm]: the ends of a line, or points along a curve, closed where it is."""
    if line is None:
        raise CutError("Draw a line on the skin first: a line or a curve of the Markups toolbar.")
    count = line.GetNumberOfDefinedControlPoints()
    if count < line.GetNumberOfControlPoints():
        raise CutError("The line is still being drawn: finish it first.")
    if count < 2:
        raise CutError(f"The line has {count} point{'s' * (count != 1)}: expected at least two, on the skin.")
    if count == 2 or line.IsA("vtkMRMLMarkupsLineNode"):
        points = slicer.util.arrayFromMarkupsControlPoints(line, world=True)
    else:
        points = np.array(slicer.util.arrayFromMarkupsCurvePoints(line, world=True))
        if line.IsA("vtkMRMLMarkupsClosedCurveNode"):
            points = np.vstack([points, points[:1]])
        points = spread(points, CURVE_POINTS_APART)
    if np.linalg.norm(np.diff(points, axis=0), axis=1).sum() < 1:
        raise CutError("The line is shorter than a millimetre.")
    return points


def samples_of(volume):
    if volume is None or volume.GetImageData() is None:
        raise CutError("Pick a volume first: a CT, in Hounsfield units.")
    samples = slicer.util.arrayFromVolume(volume)
    if samples.ndim != 3:
        raise CutError(f"{volume.GetName()}: expected a CT with one number a voxel, found {samples.shape[-1]}.")
    return samples


def add_model(name, points, triangles, color):
    used, corners = np.unique(triangles, return_inverse=True)
    cells = vtk.vtkCellArray()
    ends = numpy_to_vtkIdTypeArray(3 * np.arange(len(triangles) + 1, dtype=np.int64), deep=True)
    cells.SetData(ends, numpy_to_vtkIdTypeArray(corners.ravel().astype(np.int64), deep=True))
    places = vtk.vtkPoints()
    places.SetData(numpy_to_vtk(points[used], deep=True))
    surface = vtk.vtkPolyData()
    surface.SetPoints(places)
    surface.SetPolys(cells)
    node = slicer.mrmlScene.AddNewNodeByClass("vtkMRMLModelNode", name)
    node.SetAndObservePolyData(surface)
    node.CreateDefaultDisplayNodes()
    node.GetDisplayNode().SetColor(*color)
    node.GetDisplayNode().SetBackfaceCulling(False)
    node.GetDisplayNode().SetVisibility2D(True)
    return node


def add_table(name, columns):
    """columns: values by title, numbers or words."""
    node = slicer.mrmlScene.AddNewNodeByClass("vtkMRMLTableNode", name)
    for title, values in columns.items():
        column = vtk.vtkStringArray() if isinstance(values[0], str) else vtk.vtkDoubleArray()
        column.SetName(title)
        for value in values:
            column.InsertNextValue(value)
        node.AddColumn(column)
    return node


@dataclasses.dataclass
class UnderWay:
    """A cut, and what of its volume is needed when it is over: the volume may be gone by then."""
    cut: Cut
    name: str
    transform_id: object  # of the volume's parent transform, or None
    ijk_to_ras: np.ndarray


class TurgorLogic(ScriptedLoadableModuleLogic):
    """For scripts: TurgorLogic().cut(volume, line, Wishes(depth=12)) waits and returns the nodes by name."""

    def begin(self, volume, line, wishes=None, langer=None, program=""):
        """Starts a cut. langer: a line along Langer's lines, or none. program: where turgor is; empty, it is sought."""
        wishes = wishes or Wishes()
        samples, world_points = samples_of(volume), line_points(line)
        to_world = volume_to_world(volume)
        points = (world_points - to_world[:3, 3]) @ to_world[:3, :3]
        if langer is not None:
            ends = line_points(langer)[[0, -1]]
            wishes = dataclasses.replace(wishes, direction=(ends[1] - ends[0]) @ to_world[:3, :3])
        matrix = vtk.vtkMatrix4x4()
        volume.GetIJKToRASMatrix(matrix)
        cutter = find_cutter(program, shutil.which("PythonSlicer"), slicer.util.startupEnvironment())
        ijk_to_ras = matrix_of(matrix)
        return UnderWay(Cut(cutter, samples, ijk_to_ras, points, wishes), volume.GetName(), volume.GetTransformNodeID(), ijk_to_ras)

    def show(self, under_way):
        """The nodes of a cut that is over, by name, and what was warned of. CutError: what Turgor said."""
        opened, name = under_way.cut.opened(), under_way.name
        nodes = {"volume": slicer.util.addVolumeFromArray(opened.samples, under_way.ijk_to_ras, f"{name} cut"),
                 "skin": add_model(f"{name} skin", opened.points, opened.skin, SKIN),
                 "wound": add_model(f"{name} wound", opened.points, opened.wound, FLESH)}
        for node in nodes.values():
            node.SetAndObserveTransformNodeID(under_way.transform_id)
        names, values, units = zip(*opened.measures)
        nodes["measures"] = add_table(f"{name} wound measures", {"measure": names, "value": values, "unit": units})
        if len(opened.profile):
            along, gape = opened.profile.T
            nodes["profile"] = add_table(f"{name} gape along the cut", {"along [mm]": along, "gape [mm]": gape})
        slicer.util.setSliceViewerLayers(background=nodes["volume"])
        return nodes, opened.warnings

    def cut(self, volume, line, wishes=None, langer=None, program=""):
        under_way = self.begin(volume, line, wishes, langer, program)
        while not under_way.cut.is_over():
            time.sleep(0.05)
        return self.show(under_way)[0]


class TurgorWidget(ScriptedLoadableModuleWidget, VTKObservationMixin):
    def __init__(self, parent=None):
        ScriptedLoadableModuleWidget.__init__(self, parent)
        VTKObservationMixin.__init__(self)
        self.logic = TurgorLogic()
        self.under_way = None

    def setup(self):
        ScriptedLoadableModuleWidget.setup(self)
        self.volume = self._selector(["vtkMRMLScalarVolumeNode"], "A CT, in Hounsfield units")
        curves = ["vtkMRMLMarkupsLineNode", "vtkMRMLMarkupsCurveNode", "vtkMRMLMarkupsClosedCurveNode"]
        self.line = self._selector(curves, "Where the blade goes: a line or a curve on the skin")
        self.langer = self._selector(curves[:1], "A line along Langer's lines; none: from right to left")
        self.depth = self._number(10, 1, 100, " mm", "Of the cut, below the skin")
        self.along = self._number(45, 0, 290, " N/m", "What the skin bears along Langer's lines")
        self.across = self._number(45, 0, 290, " N/m", "What the skin bears across Langer's lines")
        self.step = self._number(4, 0.5, 20, " mm", "Of the lattice: half of it has eight times the nodes")
        self.seconds = self._number(2, 0.1, 60, " s", "Simulated: a wound settles in one or two")
        self.program = ctk.ctkPathLineEdit()
        self.program.currentPath = qt.QSettings().value("Turgor/program", "")
        self.program.toolTip = "The program turgor; may stay empty where the Python module turgor is installed"
        self.cutButton, self.cancelButton = qt.QPushButton("Cut"), qt.QPushButton("Cancel")
        self.bar, self.said = qt.QProgressBar(), qt.QLabel("")
        self.said.wordWrap = True
        form = qt.QFormLayout()
        for title, row in (("CT", self.volume), ("Line", self.line), ("Langer's lines", self.langer), ("Depth", self.depth),
                           ("Tension along", self.along), ("Tension across", self.across), ("Lattice", self.step),
                           ("Time", self.seconds), ("Program", self.program)):
            form.addRow(title, row)
        for row in (self.cutButton, self.cancelButton, self.bar, self.said):
            form.addRow(row)
        self.layout.addLayout(form)
        self.layout.addStretch(1)
        self.timer = qt.QTimer()
        self.timer.setInterval(200)
        self.timer.connect("timeout()", self.onTimer)
        self.cutButton.connect("clicked()", self.onCut)
        self.cancelButton.connect("clicked()", self.onCancel)
        self.addObserver(slicer.mrmlScene, slicer.mrmlScene.StartCloseEvent, self.onCancel)
        self._show_working(False)

    def cleanup(self):
        self.removeObservers()
        self.onCancel()

    def onCut(self):
        qt.QSettings().setValue("Turgor/program", self.program.currentPath)
        wishes = Wishes(depth=self.depth.value, tension=(self.along.value, self.across.value), step=self.step.value,
                        seconds=self.seconds.value)
        try:
            self.under_way = self.logic.begin(self.volume.currentNode(), self.line.currentNode(), wishes,
                                              self.langer.currentNode(), self.program.currentPath)
        except CutError as error:
            self.said.text = str(error)
            return
        self.said.text = ""
        self._show_working(True)
        self.timer.start()

    def onTimer(self):
        if not self.under_way.cut.is_over():
            word, part = self.under_way.cut.progress()
            self.bar.value, self.said.text = round(100 * part), word
            return
        ended = self._end()
        try:
            nodes, warnings = self.logic.show(ended)
            self.said.text = "\n".join([f"The wound is open: see {nodes['measures'].GetName()}.", *warnings])
        except CutError as error:
            self.said.text = str(error)

    def onCancel(self, caller=None, event=None):
        if self.under_way is not None:
            self._end().cut.cancel()
            self.said.text = "Cancelled: the scene is as it was."

    def _end(self):
        """The cut that was under way."""
        self.timer.stop()
        self._show_working(False)
        ended, self.under_way = self.under_way, None
        return ended

    def _show_working(self, works):
        self.cutButton.enabled, self.cancelButton.enabled, self.bar.visible = not works, works, works
        self.bar.value = 0

    def _selector(self, kinds, tip):
        selector = slicer.qMRMLNodeComboBox()
        selector.nodeTypes = kinds
        selector.noneEnabled = True
        selector.addEnabled = selector.removeEnabled = False
        selector.setMRMLScene(slicer.mrmlScene)
        selector.toolTip = tip
        return selector

    def _number(self, value, low, high, unit, tip):
        box = qt.QDoubleSpinBox()
        box.minimum, box.maximum = low, high
        box.suffix, box.value, box.toolTip = unit, value, tip
        return box
