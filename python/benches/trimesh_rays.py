"""octray against embreex through trimesh: the same queries alternately in one process, medians, results compared.

    pip install ./python trimesh embreex rtree
    python python/benches/trimesh_rays.py mesh.ply ...
"""

import statistics
import sys
import time

import numpy as np
import trimesh
from trimesh.ray.ray_pyembree import RayMeshIntersector as Embree

import octray.trimesh

ROUNDS = 5
# Seconds before each call. The threads of numpy's BLAS, which trimesh uses, keep a core busy for some 20 ms after their work.
REST = 0.1


def camera_rays(mesh, side=1000):
    """A million rays of a picture, row by row, as float64."""
    lower, upper = mesh.bounds
    middle, size = (lower + upper) / 2, np.linalg.norm(upper - lower)
    eye = middle + size * np.array([0.6, 0.8, 0.4])
    forward = (middle - eye) / np.linalg.norm(middle - eye)
    right = np.cross(forward, [0, 0, 1])
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, side), np.linspace(0.5, -0.5, side))
    directions = forward + x.reshape(-1, 1) * right + y.reshape(-1, 1) * up
    return np.tile(eye, (side * side, 1)), directions


def random_rays(mesh, count, random):
    """Rays from random points in the box, every way."""
    lower, upper = mesh.bounds
    return random.uniform(lower, upper, (count, 3)), random.normal(size=(count, 3))


def timed(ask):
    """Return the seconds that a call takes, and its answer."""
    time.sleep(REST)
    start = time.perf_counter()
    answer = ask()
    return time.perf_counter() - start, answer


def in_turn(name, ask_octray, ask_other, rounds=ROUNDS):
    """Print the median times of both, and the ratio; return their last answers."""
    asked = [(timed(ask_octray), timed(ask_other)) for _ in range(rounds)]
    ours, theirs = (statistics.median(seconds for seconds, _ in side) for side in zip(*asked))
    print(f"  {name:44} {ours * 1e3:9.1f} ms  {theirs * 1e3:9.1f} ms  {theirs / ours:7.1f}x")
    return [answer for _, answer in asked[-1]]


def main():
    """Compare on each mesh that is named."""
    for path in sys.argv[1:]:
        mesh = trimesh.load(path, force="mesh")
        random = np.random.default_rng(1)
        ours, theirs = octray.trimesh.RayMeshIntersector(mesh), Embree(mesh)
        print(f"{path}: {len(mesh.faces)} triangles, watertight: {mesh.is_watertight}")
        origins, directions = camera_rays(mesh)
        ours.intersects_first(origins[:1], directions[:1]), theirs.intersects_first(origins[:1], directions[:1])
        a, b = in_turn(
            "intersects_first, a million camera rays",
            lambda: ours.intersects_first(origins, directions),
            lambda: theirs.intersects_first(origins, directions),
        )
        print(f"    {np.mean(a == b):.5%} equal, {np.mean(a != -1):.1%} hit")
        some = random_rays(mesh, 1_000_000, random)
        a, b = in_turn(
            "intersects_first, a million random rays",
            lambda: ours.intersects_first(*some),
            lambda: theirs.intersects_first(*some),
        )
        print(f"    {np.mean(a == b):.5%} equal, {np.mean(a != -1):.1%} hit")
        some = random_rays(mesh, 100_000, random)
        a, b = in_turn(
            "intersects_location, 100,000 random rays",
            lambda: ours.intersects_location(*some, multiple_hits=True),
            lambda: theirs.intersects_location(*some, multiple_hits=True),
        )
        print(f"    {len(a[0])} and {len(b[0])} hits")
        points = random.uniform(*mesh.bounds, (100_000, 3))
        a, b = in_turn(
            "contains_points, 100,000 points",
            lambda: ours.contains_points(points),
            lambda: theirs.contains_points(points),
        )
        print(f"    {np.sum(a != b)} differ, {np.mean(a):.1%} inside")
        few = points[:1000]
        engine = ours._scene
        a, b = in_turn(
            "closest_point, 1,000 points",
            lambda: engine.closest_point(few),
            lambda: trimesh.proximity.closest_point(mesh, few),
        )
        print(f"    distances differ by at most {np.abs(a[1] - b[1]).max():.2e}")
        many = statistics.median(timed(lambda: engine.closest_point(points))[0] for _ in range(ROUNDS))
        print(f"    100,000 points: {many * 1e3:.1f} ms")


if __name__ == "__main__":
    main()
