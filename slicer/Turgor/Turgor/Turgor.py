"""Turgor in 3D Slicer: cuts the skin of a volume along a line and shows the wound, the deformed volume and measures.

This file holds the panel and converts nodes of the scene. TurgorLib.cut makes the cut in another process.
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

from TurgorLib.cut import Cut, CutError, CutOptions, find_cutter, spread

CURVE_POINTS_APART = 5  # [mm]
SKIN, FLESH = (0.88, 0.67, 0.57), (0.65, 0.23, 0.2)


class Turgor(ScriptedLoadableModule):
    def __init__(self, parent):
        ScriptedLoadableModule.__init__(self, parent)
        self.parent.title = "Turgor"
        self.parent.categories = ["Simulation"]
        self.parent.dependencies = []
        self.parent.contributors = ["The authors of Turgor"]
        self.parent.helpText = ("Select a CT, draw a line on its skin and press the button: a cut along the line opens under "
                                "the skin's tension. The module adds the wound, the deformed volume and measures to the "
                                "scene. Not a medical device.")


def matrix_of(vtk_matrix):
    return np.array([[vtk_matrix.GetElement(row, column) for column in range(4)] for row in range(4)])


def volume_to_world(volume):
    """Matrix (4, 4) from RAS of a volume to RAS of the scene. CutError: the parent transform is not rigid."""
    transform = volume.GetParentTransformNode()
    if transform is None:
        return np.eye(4)
    if not transform.IsTransformToWorldLinear():
        raise CutError("The volume has a nonlinear transform: harden the transform first.")
    matrix = vtk.vtkMatrix4x4()
    transform.GetMatrixTransformToWorld(matrix)
    to_world = matrix_of(matrix)
    if np.abs(to_world[:3, :3].T @ to_world[:3, :3] - np.eye(3)).max() > 1e-3:
        raise CutError("The volume has a transform that stretches it: harden the transform first.")
    return to_world


def line_points(line):
    """Ends of a line, or points along an open or closed curve: (n, 3) in world RAS [mm]."""
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
        raise CutError("The line is shorter than a millimeter.")
    return points


def samples_of(volume):
    if volume is None or volume.GetImageData() is None:
        raise CutError("Select a volume first: a CT, in Hounsfield units.")
    samples = slicer.util.arrayFromVolume(volume)
    if samples.ndim != 3:
        raise CutError(f"{volume.GetName()}: expected a CT with one number per voxel, found {samples.shape[-1]}.")
    return samples


def add_model(name, points, triangles, color):
    used, corners = np.unique(triangles, return_inverse=True)
    cells = vtk.vtkCellArray()
    ends = numpy_to_vtkIdTypeArray(3 * np.arange(len(triangles) + 1, dtype=np.int64), deep=True)
    cells.SetData(ends, numpy_to_vtkIdTypeArray(corners.ravel().astype(np.int64), deep=True))
    positions = vtk.vtkPoints()
    positions.SetData(numpy_to_vtk(points[used], deep=True))
    surface = vtk.vtkPolyData()
    surface.SetPoints(positions)
    surface.SetPolys(cells)
    node = slicer.mrmlScene.AddNewNodeByClass("vtkMRMLModelNode", name)
    node.SetAndObservePolyData(surface)
    node.CreateDefaultDisplayNodes()
    node.GetDisplayNode().SetColor(*color)
    node.GetDisplayNode().SetBackfaceCulling(False)
    node.GetDisplayNode().SetVisibility2D(True)
    return node


def add_table(name, columns):
    """Adds a table. columns: lists of numbers or strings by title."""
    node = slicer.mrmlScene.AddNewNodeByClass("vtkMRMLTableNode", name)
    for title, values in columns.items():
        column = vtk.vtkStringArray() if isinstance(values[0], str) else vtk.vtkDoubleArray()
        column.SetName(title)
        for value in values:
            column.InsertNextValue(value)
        node.AddColumn(column)
    return node


@dataclasses.dataclass
class RunningCut:
    """A running cut with data of its volume, since the volume may be deleted before the end."""
    cut: Cut
    name: str
    transform_id: object  # of the volume's parent transform, or None
    ijk_to_ras: np.ndarray


class TurgorLogic(ScriptedLoadableModuleLogic):
    """Scripts call TurgorLogic().cut(volume, line, CutOptions(depth=12)), which waits and returns the nodes by name."""

    def begin(self, volume, line, options=None, langer=None, program=""):
        """Starts a cut. langer: a line along Langer's lines, or None. program: path of turgor; searched if empty."""
        options = options or CutOptions()
        samples, world_points = samples_of(volume), line_points(line)
        to_world = volume_to_world(volume)
        points = (world_points - to_world[:3, 3]) @ to_world[:3, :3]
        if langer is not None:
            ends = line_points(langer)[[0, -1]]
            options = dataclasses.replace(options, direction=(ends[1] - ends[0]) @ to_world[:3, :3])
        matrix = vtk.vtkMatrix4x4()
        volume.GetIJKToRASMatrix(matrix)
        cutter = find_cutter(program, shutil.which("PythonSlicer"), slicer.util.startupEnvironment())
        ijk_to_ras = matrix_of(matrix)
        return RunningCut(Cut(cutter, samples, ijk_to_ras, points, options), volume.GetName(), volume.GetTransformNodeID(), ijk_to_ras)

    def show(self, running):
        """Adds the nodes of a finished cut; returns them by name, and warnings. CutError: the message of Turgor."""
        opened, name = running.cut.opened(), running.name
        nodes = {"volume": slicer.util.addVolumeFromArray(opened.samples, running.ijk_to_ras, f"{name} cut"),
                 "skin": add_model(f"{name} skin", opened.points, opened.skin, SKIN),
                 "wound": add_model(f"{name} wound", opened.points, opened.wound, FLESH)}
        for node in nodes.values():
            node.SetAndObserveTransformNodeID(running.transform_id)
        names, values, units = zip(*opened.measures)
        nodes["measures"] = add_table(f"{name} wound measures", {"measure": names, "value": values, "unit": units})
        if len(opened.profile):
            along, gape = opened.profile.T
            nodes["profile"] = add_table(f"{name} gape along the cut", {"along [mm]": along, "gape [mm]": gape})
        slicer.util.setSliceViewerLayers(background=nodes["volume"])
        return nodes, opened.warnings

    def cut(self, volume, line, options=None, langer=None, program=""):
        running = self.begin(volume, line, options, langer, program)
        while not running.cut.is_over():
            time.sleep(0.05)
        return self.show(running)[0]


class TurgorWidget(ScriptedLoadableModuleWidget, VTKObservationMixin):
    def __init__(self, parent=None):
        ScriptedLoadableModuleWidget.__init__(self, parent)
        VTKObservationMixin.__init__(self)
        self.logic = TurgorLogic()
        self.running = None

    def setup(self):
        ScriptedLoadableModuleWidget.setup(self)
        self.volume = self._selector(["vtkMRMLScalarVolumeNode"], "A CT, in Hounsfield units")
        curves = ["vtkMRMLMarkupsLineNode", "vtkMRMLMarkupsCurveNode", "vtkMRMLMarkupsClosedCurveNode"]
        self.line = self._selector(curves, "Path of the blade: a line or a curve on the skin")
        self.langer = self._selector(curves[:1], "A line along Langer's lines; default: from right to left")
        self.depth = self._number(10, 1, 100, " mm", "Depth of the cut below the skin")
        self.along = self._number(45, 0, 290, " N/m", "Skin tension along Langer's lines")
        self.across = self._number(45, 0, 290, " N/m", "Skin tension across Langer's lines")
        self.step = self._number(4, 0.5, 20, " mm", "Spacing of the lattice; half the spacing has eight times the nodes")
        self.seconds = self._number(2, 0.1, 60, " s", "Simulated time; a wound settles in one or two seconds")
        self.program = ctk.ctkPathLineEdit()
        self.program.currentPath = qt.QSettings().value("Turgor/program", "")
        self.program.toolTip = "Path of the program turgor; optional if the Python module turgor is installed"
        self.cutButton, self.cancelButton = qt.QPushButton("Cut"), qt.QPushButton("Cancel")
        self.bar, self.message = qt.QProgressBar(), qt.QLabel("")
        self.message.wordWrap = True
        form = qt.QFormLayout()
        for title, row in (("CT", self.volume), ("Line", self.line), ("Langer's lines", self.langer), ("Depth", self.depth),
                           ("Tension along", self.along), ("Tension across", self.across), ("Lattice", self.step),
                           ("Time", self.seconds), ("Program", self.program)):
            form.addRow(title, row)
        for row in (self.cutButton, self.cancelButton, self.bar, self.message):
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
        options = CutOptions(depth=self.depth.value, tension=(self.along.value, self.across.value), step=self.step.value,
                        seconds=self.seconds.value)
        try:
            self.running = self.logic.begin(self.volume.currentNode(), self.line.currentNode(), options,
                                              self.langer.currentNode(), self.program.currentPath)
        except CutError as error:
            self.message.text = str(error)
            return
        self.message.text = ""
        self._show_working(True)
        self.timer.start()

    def onTimer(self):
        if not self.running.cut.is_over():
            phase, fraction = self.running.cut.progress()
            self.bar.value, self.message.text = round(100 * fraction), phase
            return
        ended = self._end()
        try:
            nodes, warnings = self.logic.show(ended)
            self.message.text = "\n".join([f"The wound is open: see {nodes['measures'].GetName()}.", *warnings])
        except CutError as error:
            self.message.text = str(error)

    def onCancel(self, caller=None, event=None):
        if self.running is not None:
            self._end().cut.cancel()
            self.message.text = "Cancelled; the scene is unchanged."

    def _end(self):
        """Stops the timer and returns the cut that was running."""
        self.timer.stop()
        self._show_working(False)
        ended, self.running = self.running, None
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
