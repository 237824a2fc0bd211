"""octray against Open3D's RaycastingScene: the same queries alternately in one process, medians, results compared.

    pip install ./python open3d trimesh embreex
    python python/benches/open3d_rays.py mesh.ply ...

Open3D takes only float32, so both get float32: rays as two arrays for octray, as one array for Open3D.
"""

import sys

import numpy as np
import open3d
import trimesh
from trimesh_rays import camera_rays, in_turn, random_rays

import octray


def both(rays):
    """The rays as octray takes them, and as Open3D does."""
    origins, directions = (np.ascontiguousarray(part, np.float32) for part in rays)
    return (origins, directions), open3d.core.Tensor(np.hstack([origins, directions]))


def compare_rays(mesh, scene, name, rays, rounds=5):
    """The closest hits and whether there are any."""
    ours, theirs = both(rays)
    a, b = in_turn(
        f"closest hit, {name}", lambda: mesh.closest_hit(*ours), lambda: scene.cast_rays(theirs), rounds
    )
    triangle = b["primitive_ids"].numpy().astype(np.int64)
    triangle[triangle == open3d.t.geometry.RaycastingScene.INVALID_ID] = -1
    print(f"    {np.mean(a.triangle == triangle):.5%} equal, {np.mean(a.hit):.1%} hit")
    a, b = in_turn(f"occluded, {name}", lambda: mesh.occluded(*ours), lambda: scene.test_occlusions(theirs), rounds)
    print(f"    {np.sum(a != b.numpy())} differ")


def main():
    """Compare on each mesh that is named."""
    for path in sys.argv[1:]:
        loaded = trimesh.load(path, force="mesh")
        random = np.random.default_rng(1)
        vertices, faces = loaded.vertices.astype(np.float32), loaded.faces.astype(np.uint32)
        mesh, scene = octray.Mesh(vertices, faces), open3d.t.geometry.RaycastingScene()
        scene.add_triangles(vertices, faces)
        print(f"{path}: {len(faces)} triangles, watertight: {loaded.is_watertight}")
        compare_rays(mesh, scene, "a million camera rays", camera_rays(loaded))
        compare_rays(mesh, scene, "a million random rays", random_rays(loaded, 1_000_000, random))

        ours, theirs = both(random_rays(loaded, 100_000, random))
        a, b = in_turn(
            "all hits, 100,000 random rays", lambda: mesh.all_hits(*ours), lambda: scene.list_intersections(theirs), 3
        )
        print(f"    {len(a[0])} and {len(b['ray_ids'].numpy())} hits")

        points = random.uniform(*loaded.bounds, (100_000, 3)).astype(np.float32)
        tensor = open3d.core.Tensor(points)
        a, b = in_turn(
            "closest point, 100,000 points",
            lambda: mesh.closest_point(points),
            lambda: scene.compute_distance(tensor),
            3,
        )
        print(f"    distances differ by at most {np.abs(a[1] - b.numpy()).max():.2e}")
        if loaded.is_watertight:
            a, b = in_turn(
                "inside, 100,000 points", lambda: mesh.contains(points), lambda: scene.compute_occupancy(tensor), 3
            )
            print(f"    {np.sum(a != (b.numpy() > 0.5))} differ, {np.mean(a):.1%} inside")


if __name__ == "__main__":
    main()
