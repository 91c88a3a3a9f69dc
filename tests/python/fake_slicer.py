"""A fake of the few calls that the module of 3D Slicer makes, on plain arrays and real VTK. Import it before Turgor.py.

It behaves like the documentation and sources of Slicer (slicer.util, MRML nodes, PythonQt's properties and connect()).
Everything else is an AttributeError.
"""
import os
import pathlib
import sys
import types

import numpy as np
import vtk

MODULE = pathlib.Path(__file__).resolve().parents[2] / "slicer/Turgor/Turgor"


def vtk_matrix(array):
    matrix = vtk.vtkMatrix4x4()
    for row in range(4):
        for column in range(4):
            matrix.SetElement(row, column, array[row, column])
    return matrix


class Node:
    kind = "vtkMRMLNode"

    def __init__(self, name="", kind=None):
        self.name, self.kind, self.transform_id = name, kind or self.kind, None

    def GetName(self):
        return self.name

    def IsA(self, kind):
        return self.kind == kind

    def GetTransformNodeID(self):
        return self.transform_id

    def SetAndObserveTransformNodeID(self, transform_id):
        self.transform_id = transform_id

    def GetParentTransformNode(self):
        return mrmlScene.by_id.get(self.transform_id)


class Volume(Node):
    kind = "vtkMRMLScalarVolumeNode"

    def __init__(self, name, samples=None, ijk_to_ras=np.eye(4)):
        super().__init__(name)
        self.samples, self.ijk_to_ras = samples, np.array(ijk_to_ras)

    def GetImageData(self):
        return None if self.samples is None else vtk.vtkImageData()

    def GetIJKToRASMatrix(self, matrix):
        matrix.DeepCopy(vtk_matrix(self.ijk_to_ras))


class Markups(Node):
    """points: (n, 3), in the scene's RAS [mm]."""

    def __init__(self, kind, points, curve=None, previewed=0):
        super().__init__("L", kind)
        self.points, self.curve, self.previewed = np.array(points, dtype=float), curve, previewed

    def GetNumberOfControlPoints(self):
        return len(self.points)

    def GetNumberOfDefinedControlPoints(self):
        return len(self.points) - self.previewed


class Transform(Node):
    kind = "vtkMRMLTransformNode"

    def __init__(self, to_world, linear=True):
        super().__init__("T")
        self.to_world, self.linear = to_world, linear

    def IsTransformToWorldLinear(self):
        return self.linear

    def GetMatrixTransformToWorld(self, matrix):
        matrix.DeepCopy(vtk_matrix(self.to_world))


class Display:
    def SetColor(self, red, green, blue):
        self.color = (red, green, blue)

    def SetBackfaceCulling(self, on):
        self.culls = on

    def SetVisibility2D(self, on):
        self.seen_in_slices = on


class Model(Node):
    kind = "vtkMRMLModelNode"
    surface = display = None

    def SetAndObservePolyData(self, surface):
        self.surface = surface

    def CreateDefaultDisplayNodes(self):
        self.display = Display()

    def GetDisplayNode(self):
        return self.display


class Table(Node):
    kind = "vtkMRMLTableNode"

    def __init__(self, name):
        super().__init__(name)
        self.columns = {}

    def AddColumn(self, column):
        self.columns[column.GetName()] = [column.GetValue(row) for row in range(column.GetNumberOfValues())]


class Scene:
    StartCloseEvent = 66000

    def __init__(self):
        self.Clear()

    def Clear(self):
        self.nodes, self.by_id, self.observers = [], {}, {}

    def add(self, node):
        self.nodes.append(node)
        self.by_id[f"{node.kind}{len(self.nodes)}"] = node
        return f"{node.kind}{len(self.nodes)}"

    def AddNewNodeByClass(self, kind, name):
        node = {"vtkMRMLModelNode": Model, "vtkMRMLTableNode": Table, "vtkMRMLScalarVolumeNode": Volume}[kind](name)
        self.add(node)
        return node


mrmlScene = Scene()


def add_volume_from_array(samples, ijk_to_ras, name):
    node = mrmlScene.AddNewNodeByClass("vtkMRMLScalarVolumeNode", name)
    node.samples, node.ijk_to_ras = np.array(samples), np.array(ijk_to_ras)
    return node


shown = {}  # volumes in the slice views, set by setSliceViewerLayers


class VTKObservationMixin:
    def addObserver(self, node, event, method):
        node.observers[event] = method

    def removeObservers(self):
        mrmlScene.observers.clear()


class Base:
    def __init__(self, parent=None):
        self.parent = parent or types.SimpleNamespace()
        self.layout = Widget()

    def setup(self):
        pass


class Widget:
    """A Qt widget: properties are attributes, and connect() takes the signal's signature."""
    enabled, visible, text, value = True, True, "", 0

    def __init__(self, text=""):
        self.text, self.connected, self.rows = text, {}, []

    def connect(self, signal, slot):
        self.connected[signal] = slot

    def click(self):
        if not self.enabled:
            raise AssertionError(f"{self.text} cannot be pressed now")
        self.connected["clicked()"]()

    def addRow(self, *row):
        self.rows.append(row)

    def addLayout(self, layout):
        self.rows.append(layout)

    def addStretch(self, amount):
        pass


class Timer(Widget):
    running = False

    def setInterval(self, milliseconds):
        self.interval = milliseconds

    def start(self):
        self.running = True

    def stop(self):
        self.running = False

    def tick(self):
        if self.running:
            self.connected["timeout()"]()


class Settings:
    kept = {}

    def value(self, key, default):
        return self.kept.get(key, default)

    def setValue(self, key, value):
        self.kept[key] = value


class Selector(Widget):
    chosen = None

    def setMRMLScene(self, scene):
        self.scene = scene

    def currentNode(self):
        return self.chosen


def module(name, **contents):
    made = types.ModuleType(name)
    made.__dict__.update(contents)
    sys.modules[name] = made
    return made


util = module("slicer.util", VTKObservationMixin=VTKObservationMixin, addVolumeFromArray=add_volume_from_array,
              arrayFromVolume=lambda node: node.samples, startupEnvironment=lambda: dict(os.environ),
              arrayFromMarkupsControlPoints=lambda node, world=False: node.points.copy(),
              arrayFromMarkupsCurvePoints=lambda node, world=False: node.curve.copy(),
              setSliceViewerLayers=lambda background: shown.update(background=background))
scripted = module("slicer.ScriptedLoadableModule", ScriptedLoadableModule=Base, ScriptedLoadableModuleLogic=Base,
                  ScriptedLoadableModuleWidget=Base)
module("slicer", util=util, ScriptedLoadableModule=scripted, mrmlScene=mrmlScene, qMRMLNodeComboBox=Selector)
module("qt", QSettings=Settings, QTimer=Timer, QPushButton=Widget, QProgressBar=Widget, QLabel=Widget, QFormLayout=Widget,
       QDoubleSpinBox=Widget)
module("ctk", ctkPathLineEdit=Widget)
sys.path.insert(0, str(MODULE))
