"""A 3D scene at a time, rendered with VTK: the surface of the water, the bodies, the walls as glass.

A surface is where the number of particles per volume, smoothed over about a spacing on a grid of half a spacing, is half of what it is
inside. Its colour is the field of the particles near it, smoothed in the same way.
"""

from dataclasses import dataclass

import numpy as np

from tern.plot import screen, walls

CELLS_PER_SPACING = 2
VIEW_ANGLE = 25  # of the whole height [degrees]
MOST_CELLS = 40_000_000  # of a grid; a larger one gets coarser cells
NEAR = 4  # so far outside the box particles are still shown [spacings]
SMOOTHING = 0.6  # standard deviation of the smoothing [spacings]
BODY = (0.75, 0.75, 0.75)  # of whom nobody knows the stress


@dataclass
class Camera:
    """From where the scene is seen: turned from the front by `azimuth` to the right, raised by `elevation` [degrees]. `zoom` 1 fits it."""

    azimuth: float = 30.0
    elevation: float = 20.0
    zoom: float = 1.0


def basis(gravity):
    """(right, up, towards who stands in front), unit vectors: up is against the largest component of gravity, y without any."""
    try:
        pull = np.array([float(part) for part in gravity])
    except (TypeError, ValueError):  # expressions
        pull = np.zeros(3)
    axis = int(np.argmax(np.abs(pull))) if np.any(pull) else 1
    up = np.zeros(3)
    up[axis] = -1.0 if pull[axis] > 0 else 1.0
    right = np.eye(3)[1 if axis == 0 else 0]
    return right, up, np.cross(right, up)


def direction(camera, gravity):
    """The unit vector from the scene to the eye."""
    right, up, towards = basis(gravity)
    turn, rise = np.radians([camera.azimuth, camera.elevation])
    return np.cos(rise) * (np.cos(turn) * towards + np.sin(turn) * right) + np.sin(rise) * up


def _grid(position, spacing, box):
    """(origin, cell [m], counts) of a grid around the particles inside `box`."""
    low = np.maximum(position.min(axis=0), box[0]) - 2.5 * spacing
    high = np.minimum(position.max(axis=0), box[1]) + 2.5 * spacing
    cell = max(spacing / CELLS_PER_SPACING, (np.prod(high - low) / MOST_CELLS) ** (1 / 3))
    return low, cell, np.maximum(np.ceil((high - low) / cell).astype(int), 2)


def _smooth(values, width):
    """The values [x, y, z] of a grid after a Gaussian of `width` cells, as a flat array with x running fastest."""
    from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
    from vtkmodules.vtkCommonDataModel import vtkImageData
    from vtkmodules.vtkImagingGeneral import vtkImageGaussianSmooth
    image = vtkImageData()
    image.SetDimensions(*values.shape)
    image.GetPointData().SetScalars(numpy_to_vtk(values.ravel(order="F").astype(np.float32), deep=True))
    smoothing = vtkImageGaussianSmooth()
    smoothing.SetInputData(image)
    smoothing.SetDimensionality(3)
    smoothing.SetStandardDeviations(*3 * [width])
    smoothing.SetRadiusFactors(*3 * [3.0])
    smoothing.Update()
    return vtk_to_numpy(smoothing.GetOutput().GetPointData().GetScalars()).copy()


def surface(position, values, spacing, box, clip):
    """The surface of particles as vtkPolyData with a value at each point; None where there are none. `clip` of Scene."""
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonDataModel import vtkImageData
    from vtkmodules.vtkFiltersCore import vtkFlyingEdges3D
    around = NEAR * spacing
    box = box[0] - around, box[1] + around
    inside = np.all((position >= box[0]) & (position <= box[1]), axis=1)
    position, values = position[inside], values[inside]
    if len(position) == 0:
        return None
    low, cell, counts = _grid(position, spacing, box)
    # Each particle is shared among the eight nodes around it.
    place = (position - low) / cell
    corner = np.floor(place).astype(int)
    share = place - corner
    number, total = np.zeros(counts.prod()), np.zeros(counts.prod())
    for offset in np.ndindex(2, 2, 2):
        weight = np.prod(np.where(offset, share, 1 - share), axis=1)
        node = np.ravel_multi_index(np.minimum(corner + offset, counts - 1).T, counts)
        number += np.bincount(node, weight, minlength=len(number))
        total += np.bincount(node, weight * values, minlength=len(total))
    width = SMOOTHING * spacing / cell
    number, total = _smooth(number.reshape(counts), width), _smooth(total.reshape(counts), width)
    field = np.divide(total, number, out=np.zeros_like(total), where=number > 1e-6)
    full = (cell / spacing) ** 3
    image = vtkImageData()
    image.SetDimensions(*counts)
    image.SetOrigin(*low)
    image.SetSpacing(*3 * [cell])
    scalars = numpy_to_vtk((number / full).astype(np.float32), deep=True)
    if clip is not None:  # what is in front of the plane is empty: the surface closes along it, coloured by what is there
        axis, at, sign = clip
        coordinate = low[axis] + cell * np.arange(counts[axis])
        share = np.clip(0.5 + sign * (at - coordinate) / cell, 0, 1)  # linear over a cell: half at the plane itself
        shape = [1, 1, 1]
        shape[2 - axis] = counts[axis]
        solid = np.minimum(number / full, 1).reshape(counts[::-1]) * share.reshape(shape)
        scalars = numpy_to_vtk(np.ascontiguousarray(solid.ravel(), dtype=np.float32), deep=True)
    scalars.SetName("filled")
    image.GetPointData().SetScalars(scalars)
    colour = numpy_to_vtk(field.astype(np.float32), deep=True)
    colour.SetName("value")
    image.GetPointData().AddArray(colour)
    contour = vtkFlyingEdges3D()
    contour.SetInputData(image)
    contour.SetValue(0, 0.5)
    contour.ComputeNormalsOn()
    contour.InterpolateAttributesOn()
    contour.Update()
    found = contour.GetOutput()
    if found.GetNumberOfPoints() == 0:
        return None
    found.GetPointData().SetActiveScalars("value")
    return found


def _coloured(mesh, colours, limits):
    """The actor of a surface coloured by its values through a matplotlib colour map; grey without one."""
    import matplotlib
    from vtkmodules.vtkCommonCore import vtkLookupTable
    from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper
    mapper = vtkPolyDataMapper()
    mapper.SetInputData(mesh)
    actor = vtkActor()
    actor.SetMapper(mapper)
    if colours is None:
        mapper.ScalarVisibilityOff()
        actor.GetProperty().SetColor(*BODY)
    else:
        table = vtkLookupTable()
        table.SetNumberOfTableValues(256)
        for place, colour in enumerate(matplotlib.colormaps[colours](np.linspace(0, 1, 256))):
            table.SetTableValue(place, *colour)
        table.SetRange(*limits)
        mapper.SetLookupTable(table)
        mapper.UseLookupTableScalarRangeOn()
        mapper.InterpolateScalarsBeforeMappingOn()
    actor.GetProperty().SetAmbient(0.35)
    actor.GetProperty().SetDiffuse(0.65)
    return actor


def _box(shape, open_faces, place):
    """(mesh, edges as lines) of a box with its open faces left out."""
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
    low, high = (np.array(shape["box"][name], dtype=float) for name in ("min", "max"))
    corners = np.array(list(np.ndindex(2, 2, 2)))
    points, faces, lines = vtkPoints(), vtkCellArray(), vtkCellArray()
    for point in place(low + corners * (high - low)):
        points.InsertNextPoint(*point)
    number = {tuple(corner): place_ for place_, corner in enumerate(corners)}
    for face, (axis, end) in walls.FACES.items():
        one, two = (direction for direction in range(3) if direction != axis)
        if face in open_faces:
            continue
        faces.InsertNextCell(4)
        for a, b in ((0, 0), (1, 0), (1, 1), (0, 1)):
            corner = [0, 0, 0]
            corner[axis], corner[one], corner[two] = end, a, b
            faces.InsertCellPoint(number[tuple(corner)])
    for corner in corners:
        for axis in range(3):
            if corner[axis] == 0:
                lines.InsertNextCell(2)
                lines.InsertCellPoint(number[tuple(corner)])
                lines.InsertCellPoint(number[tuple(corner + np.eye(3, dtype=int)[axis])])
    mesh, edges = vtkPolyData(), vtkPolyData()
    mesh.SetPoints(points)
    mesh.SetPolys(faces)
    edges.SetPoints(points)
    edges.SetLines(lines)
    return mesh, edges


def _shape(wall, place):
    """The surface of any other wall: where its signed distance is 0, on a grid of 96 cells along its longest side."""
    from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
    from vtkmodules.vtkCommonDataModel import vtkImageData
    from vtkmodules.vtkFiltersCore import vtkFlyingEdges3D
    corners = walls.corners(wall)
    low, high = corners.min(axis=0), corners.max(axis=0)
    cell = (high - low).max() / 96
    axes = [np.arange(a - 2 * cell, b + 3 * cell, cell) for a, b in zip(low, high)]
    z, y, x = np.meshgrid(*axes[::-1], indexing="ij")
    shape = wall.get("container") or wall.get("obstacle")
    distance = walls.signed_distance(shape, np.column_stack([x.ravel(), y.ravel(), z.ravel()]))
    image = vtkImageData()
    image.SetDimensions(*(len(axis) for axis in axes))
    image.SetOrigin(*(axis[0] for axis in axes))
    image.SetSpacing(*3 * [cell])
    image.GetPointData().SetScalars(numpy_to_vtk(distance, deep=True))
    contour = vtkFlyingEdges3D()
    contour.SetInputData(image)
    contour.SetValue(0, 0.0)
    contour.ComputeNormalsOff()
    contour.Update()
    mesh = contour.GetOutput()
    if mesh.GetNumberOfPoints():
        mesh.GetPoints().SetData(numpy_to_vtk(place(vtk_to_numpy(mesh.GetPoints().GetData())), deep=True))
    return mesh


def _wall_actors(wall, place, plane):
    """Glass: a container hardly visible with its edges, an obstacle more so."""
    from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper
    shape = wall.get("container") or wall.get("obstacle")
    if "box" in shape:
        mesh, edges = _box(shape, wall.get("open", []), place)
    else:
        mesh, edges = _shape(wall, place), None
    for part, is_edge in ((mesh, False), (edges, True)):
        if part is None:
            continue
        mapper = vtkPolyDataMapper()
        mapper.SetInputData(part)
        mapper.ScalarVisibilityOff()
        if plane is not None:
            mapper.AddClippingPlane(plane)
        actor = vtkActor()
        actor.SetMapper(mapper)
        own = actor.GetProperty()
        own.SetColor(*(3 * [0.25] if is_edge else (0.55, 0.65, 0.75)))
        if is_edge:
            own.SetLineWidth(1.5)
            own.LightingOff()
        else:
            own.SetOpacity(0.10 if "container" in wall else 0.45)
            own.SetAmbient(0.4)
        yield actor


def _distance(box, eye, up, size):
    """How far from the middle of `box` its corners just fill the picture but for a margin [m]."""
    right = np.cross(up, eye)
    right /= np.linalg.norm(right)
    above = np.cross(eye, right)
    corners = 0.5 * (2 * np.array(list(np.ndindex(2, 2, 2))) - 1) * (box[1] - box[0])
    slope = 0.95 * np.tan(np.radians(0.5 * VIEW_ANGLE))
    return max(np.max(corners @ eye + np.abs(corners @ above) / slope),
               np.max(corners @ eye + np.abs(corners @ right) / (slope * size[0] / size[1])))


def image(parts, placed, box, gravity, camera=Camera(), clip=None, size=(1200, 800)):
    """The scene as pixels, an array [rows, columns, 3] of bytes.

    `parts`: [(position [n, 3], value of each, spacing [m], name of a colour map or None, its limits, opacity)]. `placed` of walls.placed().
    `box` (lower, upper corner) [m]: what fills the picture. `clip` (direction, coordinate [m]): what lies in front of this plane, as
    the camera sees it, is left away.
    """
    screen.start()
    import vtkmodules.vtkRenderingOpenGL2  # noqa: F401  its classes register themselves
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonDataModel import vtkPlane
    from vtkmodules.vtkRenderingCore import vtkRenderer, vtkRenderWindow, vtkWindowToImageFilter
    eye = direction(camera, gravity)
    plane = signed = None
    if clip is not None:
        axis, at = clip
        sign = 1.0 if eye[axis] >= 0 else -1.0
        signed = (axis, at, sign)
        plane = vtkPlane()
        plane.SetOrigin(*(at * np.eye(3)[axis]))
        plane.SetNormal(*(-sign * np.eye(3)[axis]))
    renderer = vtkRenderer()
    renderer.SetBackground(1, 1, 1)
    for position, values, spacing, colours, limits, opacity in parts:
        mesh = surface(position, np.asarray(values, dtype=float), spacing, box, signed)
        if mesh is not None:
            actor = _coloured(mesh, colours, limits)
            actor.GetProperty().SetOpacity(opacity)
            renderer.AddActor(actor)
    for wall, place in placed:
        for actor in _wall_actors(wall, place, plane) if place else ():
            renderer.AddActor(actor)
    _, up, towards = basis(gravity)
    up = up if abs(eye @ up) < 0.999 else -towards
    middle = 0.5 * (box[0] + box[1])
    view = renderer.GetActiveCamera()
    view.SetViewAngle(VIEW_ANGLE)
    view.SetFocalPoint(*middle)
    view.SetPosition(*(middle + _distance(box, eye, up, size) * eye))
    view.SetViewUp(*up)
    view.Zoom(camera.zoom)
    renderer.ResetCameraClippingRange()
    renderer.UseFXAAOn()
    renderer.UseDepthPeelingOn()
    renderer.SetMaximumNumberOfPeels(12)
    window = vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(0)
    window.SetAlphaBitPlanes(1)
    window.SetSize(*size)
    window.AddRenderer(renderer)
    window.Render()
    taken = vtkWindowToImageFilter()
    taken.SetInput(window)
    taken.ReadFrontBufferOff()
    taken.Update()
    pixels = vtk_to_numpy(taken.GetOutput().GetPointData().GetScalars()).reshape(size[1], size[0], 3)[::-1].copy()
    window.Finalize()
    return pixels
