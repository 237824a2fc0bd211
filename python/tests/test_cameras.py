"""Cameras and their rays: checks of numbers, up axes, and Ctrl-C."""

import os
import signal
import threading
import time
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest

import octray

VIEW = {"eye": (104, 55, 9), "target": (100, 50, 3)}


def mesh():
    corners = np.random.default_rng(0).normal(size=(300, 3)) + [100, 50, 3]
    return octray.Mesh(corners, np.arange(300).reshape(-1, 3))


@pytest.mark.parametrize("up_axis", [None, "y", "x", "-z"])
@pytest.mark.parametrize("more", [{}, {"ortho": 5}, {"up": (0, 1, 1)}, {"target": None}, {"eye": None}])
def test_rays_have_the_up_axis_of_the_picture(up_axis, more):
    subject, camera = mesh(), {**VIEW, **more}
    ids = octray.render(subject, (40, 30), camera, 1, "id", style="plain", up_axis=up_axis)["id"]
    origins, directions = octray.camera_rays(camera, (40, 30), subject, style="plain", up_axis=up_axis)
    triangles = subject.closest_hit(origins, directions).triangle.astype(np.uint32).reshape(30, 40)
    # To rounding.
    assert np.mean(triangles == ids) > 0.99 and np.any(ids != 2**32 - 1)
    if camera["eye"] is not None and camera["target"] is not None:
        alone = octray.camera_rays(camera, (40, 30), up_axis=up_axis)
        assert np.allclose(alone[0], origins, atol=1e-4) and np.allclose(alone[1], directions, atol=1e-6)


@pytest.mark.parametrize("ortho", [None, 2])
def test_interrupt_ends_rays(ortho):
    # Where SIGINT is ignored, as behind a shell's &, Python does not catch it by itself.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    timer = threading.Timer(0.1, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    start = time.monotonic()
    try:
        with pytest.raises(KeyboardInterrupt):
            octray.camera_rays({**VIEW, "ortho": ortho}, (8000, 8000))
    finally:
        signal.signal(signal.SIGINT, before)
    assert time.monotonic() - start < 2


@pytest.mark.parametrize(
    "camera",
    [
        {"fov": "60"},
        {"fov": True},
        {"fov": np.True_},
        {"fov": [60]},
        {"ortho": True},
        {"eye": ("1", "2", "3")},
        {"eye": (True, 2, 3)},
        {"eye": np.ones(3, dtype=bool)},
        {"eye": b"abc"},
        {"eye": {1, 2, 3}},
        {"eye": np.ones((3, 1))},
        {"from": ("1", 2)},
    ],
)
def test_numbers_of_cameras_are_numbers(camera):
    (name,) = camera
    with pytest.raises(ValueError, match=f"(?s)camera: {name} is .*, expected"):
        octray.render(mesh(), (4, 4), camera)


def test_numbers_of_cameras_have_any_type():
    camera = {"eye": (Fraction(7, 2), Decimal(3), np.float32(2)), "target": np.zeros(3, np.float16), "fov": np.array(30)}
    same = {"eye": (3.5, 3, 2), "target": (0, 0, 0), "fov": 30}
    assert np.array_equal(octray.camera_rays(camera, (4, 4))[1], octray.camera_rays(same, (4, 4))[1])


def test_directions_have_any_length():
    expected = octray.camera_rays({**VIEW, "up": (1, 1, 1)}, (9, 9))[1]
    for length in (1.7e308, 1e300, 1e-300, 5e-324):
        camera = {**VIEW, "up": (length,) * 3}
        assert np.allclose(octray.camera_rays(camera, (9, 9))[1], expected, atol=1e-6)
        framed = [octray.render(mesh(), (9, 9), {"up": (up, 0, 0)})["color"] for up in (1, length)]
        assert np.array_equal(*framed)
    lit = [octray.render(mesh(), (9, 9), lit_from=(0, 0, z))["color"] for z in (1, 1e-300)]
    assert np.array_equal(*lit)
    for up in ((0, 0, 0), (4, 5, 6)):
        with pytest.raises(ValueError, match="up vector is zero or parallel"):
            octray.camera_rays({**VIEW, "up": up}, (9, 9))
