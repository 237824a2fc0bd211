"""Pictures as arrays."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping, Sequence
from typing import IO, Any, SupportsFloat, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from . import _arrays, _camera, _octray
from ._mesh import Mesh
from ._scene import Scene

_AOVS = ("depth", "z", "normal", "albedo", "id", "instance", "mask")
_MOST_SAMPLES = 1 << 20
_MOST_DEPTH = 1000
_LAST_FRAME = 100_000
_LONGEST = 1e6
_WIDEST_EDGES = 100


def render(
    source: str | bytes | os.PathLike[str] | IO[bytes] | Mesh | Scene,
    size: Sequence[SupportsIndex] | NDArray[np.integer[Any]] = (512, 512),
    camera: str | SupportsIndex | Mapping[str, Any] | None = None,
    samples: SupportsIndex | str = "usual",
    aov: str | Sequence[str] = (),
    style: str | None = None,
    *,
    vertex_colors: ArrayLike | Sequence[ArrayLike | None] | None = None,
    face_colors: ArrayLike | Sequence[ArrayLike | None] | None = None,
    values: ArrayLike | None = None,
    color_by: str | None = None,
    color_map: str | None = None,
    color_range: Sequence[SupportsFloat] | NDArray[Any] | None = None,
    background: str = "scene",
    dtype: DTypeLike = np.uint8,
    srgb: bool | None = None,
    max_depth: SupportsIndex = 3,
    shadows: bool = True,
    edges: bool | SupportsFloat = False,
    frame: SupportsIndex | None = None,
    ground: bool = False,
    up_axis: str | None = None,
    smooth_angle: SupportsFloat | None = None,
    point_size: SupportsFloat | None = None,
    lit_from: ArrayLike | None = None,
    environment: str | bytes | os.PathLike[str] | None = None,
    environment_rotate: SupportsFloat = 0.0,
    animation: str | SupportsIndex | None = None,
    animation_time: SupportsFloat | None = None,
) -> dict[str, NDArray[Any]]:
    """Render a scene (``.scn``), a mesh file, a :class:`Mesh` or a :class:`Scene`, like the program ``octray``.

    Arguments mean what the program's options of the same names mean.

    Parameters
    ----------
    source
        A path; a :class:`Mesh` or a :class:`Scene` of meshes, whose z axis points up; or a binary file, such as ``io.BytesIO``,
        whose format is recognised by its content. Files that it names are read from the folder of its ``name``, or else from
        the current one. Of a :class:`Scene` each mesh is stored once. Options and arrays that concern a mesh concern all of its
        instances together.
    size
        Width and height, pixels.
    camera
        A camera of the file by name, a classic viewpoint from 1 to 6, or a dictionary with any of ``eye``, ``target``,
        ``up`` (three numbers each), ``fov`` (degrees, vertical) or ``ortho`` (the height of an orthographic view, scene
        units, or ``"fit"``, which frames a mesh), ``aperture`` (the diameter of a lens, scene units) and ``focus`` (the
        distance in focus, scene units). Instead of ``eye``, ``from`` frames a mesh from its ``"front"``, ``"right"``,
        ``"back"``, ``"left"``, ``"top"`` or ``"bottom"``, or from an azimuth and an elevation in degrees. By default the
        scene's first camera, or one that frames the mesh.
    samples
        Samples per pixel: a number; ``"auto"`` or ``"auto:N"``, which take up to 16 or N, fewer in pixels that look like
        their neighbours; or ``"usual"``, which is 1, or ``"auto"`` for meshes in the studio and clay styles.
    aov
        More arrays, by name: ``"depth"``, ``"z"``, ``"normal"``, ``"albedo"``, ``"id"``, ``"instance"``, ``"mask"``, each of
        one ray through the pixel's centre.
    style
        How a mesh is lit: ``"studio"``, the default, soft light with ambient occlusion; ``"clay"``, the same with one
        colour for all of it; ``"plain"``, two point lights. A scene has its own light.
    vertex_colors, face_colors
        Colours of a :class:`Mesh`, shape (n, 3) or (m, 3): ``uint8``, or floats from 0 to 1, in sRGB as those of PLY files.
        A fourth column, alpha, must be opaque. Clay leaves them out. Of a :class:`Scene` a list with such an array, or None, for
        each of its ``meshes``; one mesh may have colours of vertices and another of faces.
    values
        Numbers of a :class:`Mesh` that are shown as colours, one for each vertex, shape (n,), or for each face, shape (m,); of
        vertices if n equals m. What is not finite is grey.
    color_by
        The same of a file: the name of a scalar property of a PLY or glTF file, such as ``"quality"``. ``"x"``, ``"y"`` or
        ``"z"`` shows a coordinate, also of a :class:`Mesh`.
    color_map
        Their colours: ``"viridis"``, the default, ``"turbo"``, ``"greys"``, ``"rdbu"`` or another of ``--color-map``.
    color_range
        The two numbers that have the first and the last colour; by default the smallest and the largest. If the first is
        larger, the colours are reversed.
    background
        ``"scene"``; ``"transparent"``, which gives pixels that show nothing an alpha of 0; or a colour, ``"white"``,
        ``"black"`` or six hexadecimal digits. Mirrors and glass still show the scene's background.
    dtype
        Of the colours: ``uint8``, or ``float32``, linear and, with alpha, premultiplied, as in an EXR file.
    srgb
        Whether bytes are in sRGB, or linear; by default they are for meshes, unless ``style="plain"``.
    max_depth
        Maximum ray depth; 1 disables reflections and refraction.
    shadows
        Whether there are shadows.
    edges
        Whether the edges of triangles are drawn, as lines one pixel wide; or the width of the lines, pixels.
    frame
        The frame of a scene with keyframes, from 1 on.
    ground
        Whether the mesh is on a ground plane.
    up_axis
        Which axis of a mesh points up: ``"x"``, ``"y"``, ``"z"``, ``"-x"``, ``"-y"`` or ``"-z"``. By default y, but z for
        a :class:`Mesh`, a :class:`Scene`, STL, 3MF, VTK and PLY files that say so.
    smooth_angle
        Smooths a mesh without normals where faces meet at no more than this angle, degrees. Those of a :class:`Scene` are
        smoothed before they are placed.
    point_size
        Diameter of the points or lines of a file without faces, scene units.
    lit_from
        The direction, three numbers, from which a mesh would be seen to be lit like this; by default that of the camera.
    environment
        The path of an environment map that lights a mesh instead, equirectangular: ``.hdr``, ``.exr`` or another picture.
        Needs many samples, such as ``"auto:64"``.
    environment_rotate
        Turns the environment map counterclockwise as seen from above, degrees.
    animation, animation_time
        Show a glTF file in the pose of this animation, by name or number, at this time, seconds. One is enough: the first
        animation, or time 0.

    Returns
    -------
    dict
        ``"color"``: shape (height, width, 3), or 4 with alpha; ``"depth"``: (height, width) ``float32``, the distance from
        the eye, scene units, infinite for a miss; ``"z"``: the same along the view; ``"normal"``, ``"albedo"``:
        (height, width, 3) ``float32``; ``"id"``: (height, width) ``uint32``, the index of the primitive, 2^32 - 1 for a
        miss; ``"instance"``: ``uint32``, 0 for a miss, 1 outside of instances, 2 for the first instance, ...; ``"mask"``:
        ``bool``, whether the ray hits. In an instance of a :class:`Scene` ``"id"`` is the triangle of its mesh, and
        ``"instance"`` is 2 plus the index of the instance, as the hits of rays have them; a ground is outside of instances.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    MemoryError
        If the picture or the scene would not fit into memory.
    ValueError
        If an argument is invalid, or the file is faulty: then with line and column.
    """
    return rendered(3, **locals())


def rendered(stacklevel: int, *, source, size, camera, aov, **options) -> dict[str, NDArray[Any]]:
    """Render what :func:`render` does. Warnings point to the caller that is ``stacklevel`` calls away."""
    names = (aov,) if isinstance(aov, str) else _arrays.items(aov)
    if names is None or not all(isinstance(name, str) and name in _AOVS for name in names):
        raise ValueError(f"aov: expected names among {', '.join(_AOVS)}, found {_arrays.shown(aov)}")
    width, height = _camera.size_of(size)
    checked = {**_look(options), **_of_mesh(options), **_colors(source, options), "aov": list(dict.fromkeys(names))}
    if isinstance(source, (Mesh, Scene)):
        for name in ("animation", "animation_time"):
            if options[name] is not None:
                raise ValueError(f"{name}: a {type(source).__name__} has no animations, only glTF files")
    view, subject = _camera.checked(camera), _subject(source)
    arrays, notes = _octray.render(subject, (width, height), view, checked)
    for note in notes:
        warnings.warn(note, stacklevel=stacklevel)
    return {name: arrays[name] for name in ("color", *names)}


def _subject(source) -> Any:
    """Return a mesh or a scene of meshes for the native code, a path, or bytes and their name."""
    if isinstance(source, (Mesh, Scene)):
        return _camera.solid("source", source, "render")
    if isinstance(source, (str, bytes, os.PathLike)):
        path = os.fsdecode(source)
        # A file of that name: to the program it is standard input.
        return "./-" if path == "-" else path
    if not callable(getattr(source, "read", None)):
        raise ValueError(f"source: expected a path, a binary file, a Mesh or a Scene, found {_arrays.shown(source)}")
    content = source.read()
    if not isinstance(content, (bytes, bytearray, memoryview)):
        found = type(content).__name__
        raise ValueError(f"source: expected a file that is opened in binary mode, found one whose read returns {found}")
    name = getattr(source, "name", None)
    return bytes(content), name if isinstance(name, str) and name else "source"


def _colors(source, options) -> dict[str, list[NDArray[np.float32] | None]]:
    """Return the colours of the vertices and faces of each mesh."""
    names = ("vertex_colors", "face_colors")
    given = [name for name in names if options[name] is not None]
    arrays: list[Sequence[Any]]
    if isinstance(source, Mesh):
        meshes, arrays, labels = [source._mesh], [[options[name]] for name in names], [""]
    elif isinstance(source, Scene):
        meshes = [mesh._mesh for mesh in source._meshes]
        arrays = [_of_each(name, options[name], len(meshes)) for name in names]
        labels = [f" of mesh {i}" for i in range(len(meshes))]
    elif given:
        raise ValueError(f"{given[0]}: expected None for a file, which has its own colours")
    else:
        return {**{name: [] for name in names}, **_values(source, options, given)}
    for label, *both in zip(labels, *arrays):
        if not any(colors is None for colors in both):
            raise ValueError(f"face_colors{label}: expected vertex_colors or face_colors, found both")
    colors: dict[str, Any] = {
        name: [
            None if colors is None else _arrays.colors(name + label, colors, mesh.counts[i])
            for label, colors, mesh in zip(labels, each, meshes)
        ]
        for i, (name, each) in enumerate(zip(names, arrays))
    }
    return {**colors, **_values(source, options, given)}


def _of_each(name: str, value, count: int) -> Sequence[Any]:
    """Return an array, or None, for each mesh of a scene."""
    if value is None:
        return [None] * count
    each = _arrays.items(value)
    is_list = each is not None and not isinstance(value, (str, bytes, Mapping))
    if not is_list or len(each) != count:
        found = f"{len(each)}" if is_list else _arrays.shown(value)
        raise ValueError(f"{name}: expected a list with an array or None for each of {count} meshes, found {found}")
    return each


def _values(source, options, colors: list[str]) -> dict[str, Any]:
    """Return the numbers that are shown as colours. ``colors`` are the names of given colours."""
    values, by, ends = (options[name] for name in ("values", "color_by", "color_range"))
    given = [name for name in ("values", "color_by") if options[name] is not None]
    if given and len([*given, *colors]) > 1:
        raise ValueError(f"{given[-1]}: expected {' or '.join([*colors, *given])}, found more than one")
    if given and isinstance(source, Scene):
        raise ValueError(f"{given[0]}: expected None for a Scene, whose meshes take vertex_colors or face_colors")
    for name in ("color_map", "color_range"):
        if options[name] is not None and not given:
            raise ValueError(f"{name}: needs values or color_by")
    if by is not None and not isinstance(by, str):
        raise ValueError(f"color_by: expected a name, found {_arrays.shown(by)}")
    if by is not None and isinstance(source, Mesh) and by not in ("x", "y", "z"):
        raise ValueError(f"color_by: expected x, y or z for a Mesh, or values instead, found {_arrays.shown(by)}")
    if values is not None and not isinstance(source, Mesh):
        raise ValueError("values: expected None for a file; color_by names a property of it")
    if not isinstance(options["color_map"], (str, type(None))):
        raise ValueError(f"color_map: expected a name, found {_arrays.shown(options['color_map'])}")
    if ends is not None:
        what = "two different finite numbers"
        pair = _arrays.items(ends)
        if pair is None or isinstance(ends, str) or len(pair) != 2:
            raise ValueError(f"color_range: expected {what}, found {_arrays.shown(ends)}")
        ends = [_arrays.number("color_range", end, what) for end in pair]
        if ends[0] == ends[1]:
            raise ValueError(f"color_range: expected {what}, found {ends[0]} twice")
    checked: dict[str, Any] = dict.fromkeys(("vertex_values", "face_values"))
    if values is not None:
        vertices, faces = source._mesh.counts
        values = _arrays.values("values", values, vertices, faces)
        checked["vertex_values" if len(values) == vertices else "face_values"] = values
        by = "values"
    return {**checked, "color_by": by, "color_map": options["color_map"], "color_range": ends}


def _look(options) -> dict[str, Any]:
    """Return the options that concern scenes as well as meshes."""
    background = options["background"]
    if not isinstance(background, str):
        raise ValueError(f"background: expected scene, transparent or a colour, found {_arrays.shown(background)}")
    try:
        dtype = None if options["dtype"] is None else np.dtype(options["dtype"])
    except TypeError:
        dtype = None
    if dtype not in (np.uint8, np.float32):
        raise ValueError(f"dtype: expected uint8 or float32, found {_arrays.shown(options['dtype'])}")
    srgb = options["srgb"]
    if srgb is not None:
        srgb = _arrays.flag("srgb", srgb)
    floats = dtype == np.float32
    if floats and srgb:
        raise ValueError("srgb: expected False or None for float32, which is linear")
    frame = options["frame"]
    return {
        "samples": _samples(options["samples"]),
        "background": str(background),
        "floats": floats,
        "srgb": srgb,
        "max_depth": _arrays.count_up_to("max_depth", options["max_depth"], _MOST_DEPTH),
        "shadows": _arrays.flag("shadows", options["shadows"]),
        "edges": _edges(options["edges"]),
        "frame": None if frame is None else _arrays.count_up_to("frame", frame, _LAST_FRAME),
    }


def _of_mesh(options) -> dict[str, Any]:
    """Return the options that concern meshes."""
    angle, point, time = (options[name] for name in ("smooth_angle", "point_size", "animation_time"))
    if angle is not None:
        angle = _arrays.number("smooth_angle", angle, "degrees from 0 to 180", 0, 180)
    if point is not None:
        what = "a diameter above 0 and at most 1e9"
        point = _arrays.number("point_size", point, what, 1e-44, _camera.FARTHEST)
    if time is not None:
        what = "seconds, at least 0 and at most 1000000"
        time = _arrays.number("animation_time", time, what, 0, _LONGEST)
    lit_from = options["lit_from"]
    if lit_from is not None:
        lit_from = _direction("lit_from", lit_from)
    environment, animation = options["environment"], options["animation"]
    if environment is not None:
        if not isinstance(environment, (str, bytes, os.PathLike)):
            raise ValueError(f"environment: expected a path, found {_arrays.shown(environment)}")
        if lit_from is not None:
            raise ValueError("lit_from: expected environment or lit_from, found both")
        environment = os.fsdecode(environment)
    rotation = _arrays.number("environment_rotate", options["environment_rotate"], "degrees")
    if rotation != 0 and environment is None:
        raise ValueError("environment_rotate: needs an environment")
    if animation is not None and not isinstance(animation, str):
        animation = str(_arrays.count("animation", animation, least=1))
    return {
        "style": _arrays.one_of("style", options["style"], _camera.STYLES),
        "ground": _arrays.flag("ground", options["ground"]),
        "up_axis": _arrays.one_of("up_axis", options["up_axis"], _camera.AXES),
        "smooth_angle": angle,
        "point_size": point,
        "lit_from": lit_from,
        "environment": environment,
        "environment_rotate": rotation,
        "animation": animation,
        "animation_time": time,
    }


def _direction(name: str, value) -> list[float]:
    """Return three numbers that are not all 0."""
    vector = _arrays.vectors(name, value, one=True)
    if vector.shape != (1, 3) or not np.isfinite(vector).all() or np.abs(vector).max() > _camera.FARTHEST:
        raise ValueError(f"{name}: expected three numbers of at most {_camera.FARTHEST:g}, found {_arrays.shown(value)}")
    if not vector.any():
        raise ValueError(f"{name}: expected a direction, found one without length")
    return vector[0].astype(np.float64).tolist()


def _edges(edges: bool | SupportsFloat) -> float | None:
    """Return the width of edges, pixels, or None for no edges."""
    if isinstance(edges, (bool, np.bool_)):
        return 1.0 if edges else None
    what = f"True, False, or a width in pixels above 0 and at most {_WIDEST_EDGES}"
    return _arrays.number("edges", edges, what, 1e-44, _WIDEST_EDGES)


def _samples(samples: SupportsIndex | str) -> str | None:
    """Return the samples as the program takes them, or None for the usual ones."""
    if isinstance(samples, str):
        number = samples.removeprefix("auto:")
        # What is no number, or one longer than Python reads, the program refuses.
        is_number = number.isascii() and number.isdigit() and len(number) < 1000
        most = int(number) if is_number else 0
    else:
        most = _arrays.count("samples", samples, least=1)
    if most > _MOST_SAMPLES:
        raise ValueError(f"samples: expected at most {_MOST_SAMPLES}, found {_arrays.shown(samples)}")
    if isinstance(samples, str):
        return None if samples == "usual" else samples
    return str(most)
