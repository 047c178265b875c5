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
SIZE = (1200, 800)  # of a picture [pixels]
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


def _shared(position, low, cell, counts, values=None):
    """Each particle shared among the eight nodes around it: their number at each node of a grid or, with `values`, the sum of those."""
    place = (position - low) / cell
    corner = np.floor(place).astype(int)
    share = place - corner
    total = np.zeros(counts.prod())
    for offset in np.ndindex(2, 2, 2):
        weight = np.prod(np.where(offset, share, 1 - share), axis=1)
        node = np.ravel_multi_index(np.minimum(corner + offset, counts - 1).T, counts)
        total += np.bincount(node, weight if values is None else weight * values, minlength=len(total))
    return total.reshape(counts)


def surface(position, values, spacing, box, clip, bodies=()):
    """The surface of particles as vtkPolyData with a value at each point; None where there are none. `clip` of image().

    `bodies`: [(position, spacing [m])] of what lies in the particles. They count as filled, so that there is no surface between both: it
    would lie in that of the body. Where there are more bodies than particles, the surface is that of a body and is left away.
    """
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonDataModel import vtkImageData
    from vtkmodules.vtkFiltersCore import vtkClipPolyData, vtkFlyingEdges3D
    around = NEAR * spacing
    box = box[0] - around, box[1] + around
    inside = np.all((position >= box[0]) & (position <= box[1]), axis=1)
    position, values = position[inside], values[inside]
    if len(position) == 0:
        return None
    low, cell, counts = _grid(position, spacing, box)
    width = SMOOTHING * spacing / cell
    full = (cell / spacing) ** 3
    number = _smooth(_shared(position, low, cell, counts), width) / full
    total = _smooth(_shared(position, low, cell, counts, values), width) / full
    field = np.divide(total, number, out=np.zeros_like(total), where=number > 1e-6)
    filled, own = number, None
    if bodies:
        solid = np.zeros(counts)
        for place, step in bodies:
            near = np.all((place >= low) & (place < low + cell * (counts - 1)), axis=1)
            solid += _shared(place[near], low, cell, counts) * (step / cell) ** 3
        solid = _smooth(solid, width)
        filled, own = number + solid, number - solid
    image = vtkImageData()
    image.SetDimensions(*counts)
    image.SetOrigin(*low)
    image.SetSpacing(*3 * [cell])
    if clip is not None:  # what is in front of the plane is empty: the surface closes along it, coloured by what is there
        axis, at, sign = clip
        coordinate = low[axis] + cell * np.arange(counts[axis])
        share = np.clip(0.5 + sign * (at - coordinate) / cell, 0, 1)  # linear over a cell: half at the plane itself
        shape = [1, 1, 1]
        shape[2 - axis] = counts[axis]
        filled = (np.minimum(filled, 1).reshape(counts[::-1]) * share.reshape(shape)).ravel()
    scalars = numpy_to_vtk(filled.astype(np.float32), deep=True)
    scalars.SetName("filled")
    image.GetPointData().SetScalars(scalars)
    colour = numpy_to_vtk(field.astype(np.float32), deep=True)
    colour.SetName("value")
    image.GetPointData().AddArray(colour)
    if own is not None:
        difference = numpy_to_vtk(own.astype(np.float32), deep=True)
        difference.SetName("own")
        image.GetPointData().AddArray(difference)
    contour = vtkFlyingEdges3D()
    contour.SetInputData(image)
    contour.SetValue(0, 0.5)
    contour.ComputeNormalsOn()
    contour.InterpolateAttributesOn()
    contour.Update()
    found = contour.GetOutput()
    if own is not None and found.GetNumberOfPoints():
        found.GetPointData().SetActiveScalars("own")
        dry = vtkClipPolyData()
        dry.SetInputData(found)
        dry.SetValue(0.0)
        dry.Update()
        found = dry.GetOutput()
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
        scale = matplotlib.colormaps[colours] if isinstance(colours, str) else colours
        for place, colour in enumerate(scale(np.linspace(0, 1, 256))):
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


def _wall_actors(wall, place, plane, colour=(0.55, 0.65, 0.75)):
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
        own.SetColor(*(3 * [0.25] if is_edge else colour))
        if is_edge:
            own.SetLineWidth(1.5)
            own.LightingOff()
        else:
            own.SetOpacity(0.10 if "container" in wall else 0.45)
            own.SetAmbient(0.4)
        yield actor


def _distance(box, axes, size):
    """How far from the middle of `box` its corners just fill the picture but for a margin [m]."""
    right, above, eye = axes
    corners = 0.5 * (2 * np.array(list(np.ndindex(2, 2, 2))) - 1) * (box[1] - box[0])
    slope = 0.95 * np.tan(np.radians(0.5 * VIEW_ANGLE))
    return max(np.max(corners @ eye + np.abs(corners @ above) / slope),
               np.max(corners @ eye + np.abs(corners @ right) / (slope * size[0] / size[1])))


def axes_of(camera, gravity):
    """(to the right, up in the picture, towards the eye), unit vectors."""
    eye = direction(camera, gravity)
    _, up, towards = basis(gravity)
    right = np.cross(up if abs(eye @ up) < 0.999 else -towards, eye)
    right /= np.linalg.norm(right)
    return right, np.cross(eye, right), eye


def projected(points, box, gravity, camera, size=SIZE):
    """Where points [n, 3] are in the picture of image(): columns and rows of pixels, an array [n, 2]."""
    right, above, eye = axes = axes_of(camera, gravity)
    arm = np.asarray(points, dtype=float) - 0.5 * (box[0] + box[1])
    scale = 0.5 * size[1] / np.tan(np.radians(0.5 * VIEW_ANGLE / camera.zoom)) / (_distance(box, axes, size) - arm @ eye)
    return np.column_stack([0.5 * size[0] + scale * (arm @ right), 0.5 * size[1] - scale * (arm @ above)])


def image(parts, placed, box, gravity, camera=Camera(), clip=None, size=SIZE, outlines=()):
    """The scene as pixels, an array [rows, columns, 3] of bytes.

    `parts`: [(position [n, 3], value of each, spacing [m], a colour map, its name or None, its limits, opacity)]; the first is what the
    others may lie in. `placed` of walls.placed(). `outlines`: [(shape, colour)] drawn as coloured glass.
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
    for part, (position, values, spacing, colours, limits, opacity) in enumerate(parts):
        within = [(other[0], other[2]) for other in parts[1:]] if part == 0 else []
        mesh = surface(position, np.asarray(values, dtype=float), spacing, box, signed, within)
        if mesh is not None:
            actor = _coloured(mesh, colours, limits)
            actor.GetProperty().SetOpacity(opacity)
            renderer.AddActor(actor)
    for wall, place in placed:
        for actor in _wall_actors(wall, place, plane) if place else ():
            renderer.AddActor(actor)
    for shape, colour in outlines:
        for actor in _wall_actors({"obstacle": shape}, lambda points: points, plane, colour):
            renderer.AddActor(actor)
    axes = axes_of(camera, gravity)
    middle = 0.5 * (box[0] + box[1])
    view = renderer.GetActiveCamera()
    view.SetViewAngle(VIEW_ANGLE)
    view.SetFocalPoint(*middle)
    view.SetPosition(*(middle + _distance(box, axes, size) * eye))
    view.SetViewUp(*axes[1])
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
