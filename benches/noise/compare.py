"""Compares how long octray, Blender's Cycles and POV-Ray take for pictures of equal noise, on two equivalent scenes.

    pip install numpy trimesh OpenEXR bpy       (bpy asks for one version of Python: 5.0 for 3.11)
    apt-get install povray
    cargo build --release && python benches/noise/compare.py [FOLDER]

The statue in the light of a sphere, and balls of glass, mirror and matte colours in that of a square: only direct light,
512x512, two threads, no denoiser, a box filter. Noise is the root mean square difference from the same program's picture
with many samples (kept in FOLDER), as a share of its mean. octray is timed from start to end of the process, Cycles by its
render operator, POV-Ray by its own "Trace Time", without reading the scene. POV-Ray's glass casts no shadow.
"""

import contextlib
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile
import time

import numpy as np
import OpenEXR
import trimesh

OCTRAY = pathlib.Path(__file__).resolve().parents[2] / "target/release/octray"
CYCLES = pathlib.Path(__file__).with_name("blender.py")
SIZE = ["512x512", "+W512", "+H512"]

SCENES = {
    "statue": """ambient 0
camera eye 3.2 -1.6 1.7 target 0 0 0.62 fov 45
background 0 0 0
light 3 -4 6 1 radius 1.2
material matte cd 0.6 0.6 0.6
mesh figure-slab.ply
material matte cd 0.8 0.6 0.5
mesh figure.ply
""",
    "balls": """ambient 0
camera eye 0 -6 2.2 target 0 0 0.8 fov 40
background 0.3 0.4 0.5
light 0 -1.5 5 1 rectangle 0 1.5 0 1.5 0 0
material matte cd 0.7 0.7 0.7
triangle -20 -20 0 20 -20 0 20 20 0
triangle -20 -20 0 20 20 0 -20 20 0
material matte cd 0.8 0.3 0.2
sphere -2.1 0.4 0.8 0.8
material reflection cd 0.95 0.95 0.95 mix 0.95
sphere 0 1.2 1 1
material glass ior 1.5
sphere 0.4 -1.2 0.6 0.6
material matte cd 0.2 0.4 0.8
sphere 2.1 0.2 0.8 0.8
""",
}

# How many samples a pixel; of POV-Ray, points on a side of its light and rays on a side of a pixel.
SAMPLES = {"octray": [4, 16, 64], "cycles": [16, 64], "povray": [(2, 2), (4, 2), (4, 4)]}
MANY = {"octray": 4096, "cycles": 2048, "povray": (8, 6)}


def vector(numbers):
    """POV-Ray's spelling."""
    return "<" + ",".join(f"{number:.7g}" for number in numbers) + ">"


def matte(color):
    return f"texture{{pigment{{rgb {vector(color)}}} finish{{ambient 0 diffuse 1}}}}"


def povray_mesh(path, color, smooth):
    mesh = trimesh.load(path, process=False)
    lists = {"vertex_vectors": mesh.vertices}
    if smooth:
        lists["normal_vectors"] = mesh.vertex_normals
    lists["face_indices"] = mesh.faces
    parts = (f"{name}{{{len(rows)},{','.join(map(vector, rows))}}}" for name, rows in lists.items())
    return f"mesh2{{{' '.join(parts)} {matte(color)}}}\n"


def povray_scene(scene, points):
    """The scene with this many points on a side of its light."""
    statue = scene == "statue"
    eye, target, fov = ((3.2, -1.6, 1.7), (0, 0, 0.62), 45) if statue else ((0, -6, 2.2), (0, 0, 0.8), 40)
    at, side, shape = ((3, -4, 6), 2.4, "circular orient") if statue else ((0, -1.5, 5), 1.5, "")
    text = (
        "#version 3.7; global_settings{assumed_gamma 1 max_trace_level 9}\n"
        f"camera{{perspective location {vector(eye)} up y right -x sky z angle {fov} look_at {vector(target)}}}\n"
        f"light_source{{{vector(at)} rgb 1 area_light <{side},0,0>,<0,{side},0>,{points},{points} jitter {shape}}}\n"
    )
    if statue:
        return text + povray_mesh("figure-slab.ply", (0.6, 0.6, 0.6), False) + povray_mesh("figure.ply", (0.8, 0.6, 0.5), True)
    ground = ",".join(map(vector, [(-20, -20, 0), (20, -20, 0), (20, 20, 0), (-20, 20, 0), (-20, -20, 0)]))
    mirror = "texture{pigment{rgb 0} finish{ambient 0 diffuse 0 reflection .95}}"
    glass = "texture{pigment{rgbf 1} finish{ambient 0 diffuse 0 reflection{0,1 fresnel} conserve_energy}} interior{ior 1.5}"
    return text + (
        "background{rgb <.3,.4,.5>}\n"
        f"polygon{{5,{ground} {matte((0.7, 0.7, 0.7))}}}\n"
        f"sphere{{<-2.1,.4,.8>,.8 {matte((0.8, 0.3, 0.2))}}} sphere{{<0,1.2,1>,1 {mirror}}}\n"
        f"sphere{{<.4,-1.2,.6>,.6 {glass}}} sphere{{<2.1,.2,.8>,.8 {matte((0.2, 0.4, 0.8))}}}\n"
    )


def render(program, scene, samples, picture):
    """Write a picture; return the seconds."""
    if program == "octray":
        command = [OCTRAY, f"{scene}.scn", "-q", "--force", "-j2", "-s", SIZE[0], "--samples", str(samples), "-o", picture]
        start = time.perf_counter()
        subprocess.run(command + ["--max-depth", "9"], check=True)
        return time.perf_counter() - start
    if program == "cycles":
        command = [sys.executable, CYCLES, scene, str(samples), pathlib.Path(picture).resolve()]
        return float(re.search(r"seconds: ([\d.]+)", subprocess.run(command, capture_output=True, text=True).stdout)[1])
    points, rays = samples
    pathlib.Path("scene.pov").write_text(povray_scene(scene, points))
    command = ["povray", "scene.pov", *SIZE[1:], "+WT2", "-D", "+A0.0", "+AM1", f"+R{rays}", "+FE", f"+O{picture}"]
    said = subprocess.run(command, capture_output=True, text=True).stderr
    return float(re.search(r"Trace Time.*\(([\d.]+) seconds", said)[1])


def pixels(picture):
    """Linear red, green and blue."""
    with OpenEXR.File(str(picture)) as file:
        channels = file.channels()
        for name in ("RGB", "RGBA"):
            if name in channels:
                return channels[name].pixels[..., :3].astype(np.float64)
        return np.stack([channels[name].pixels for name in "RGB"], -1).astype(np.float64)


def unlike(picture, other):
    """How much two pictures differ where it is not about noise: blocks of 16x16 pixels, each picture by its own mean."""
    blocks = [image.reshape(32, 16, 32, 16, 3).mean((1, 3)) / image.mean() for image in (picture, other)]
    return np.abs(blocks[0] - blocks[1]).mean()


def compare(folder):
    """Print a line for each program and number of samples; and how much the programs' exact pictures differ."""
    print(f"{'scene':8} {'program':8} {'samples':>8} {'seconds':>8} {'noise':>7}")
    for scene in SCENES:
        for program, counts in SAMPLES.items():
            reference = folder / f"{scene}-{program}.exr"
            if not reference.exists():
                render(program, scene, MANY[program], reference)
            exact = pixels(reference)
            if program != "octray":
                difference = unlike(exact, pixels(folder / f"{scene}-octray.exr"))
                print(f"{scene:8} {program:8} differs from octray's picture by {difference:.1%}")
            for samples in counts:
                seconds = statistics.median(render(program, scene, samples, "picture.exr") for _ in range(3))
                noise = np.sqrt(np.mean((pixels("picture.exr") - exact) ** 2)) / exact.mean()
                print(f"{scene:8} {program:8} {samples!s:>8} {seconds:8.3f} {noise:7.2%}", flush=True)


def main():
    """Run in FOLDER, or in one that is removed."""
    with tempfile.TemporaryDirectory() as made:
        folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else made).resolve()
        folder.mkdir(exist_ok=True)
        with contextlib.chdir(folder):
            subprocess.run([OCTRAY, "generate", "figure", "--force"], check=True, stdout=subprocess.DEVNULL)
            for scene, text in SCENES.items():
                pathlib.Path(f"{scene}.scn").write_text(text)
            compare(folder)


if __name__ == "__main__":
    main()
