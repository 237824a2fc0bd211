"""The package as it is installed: its program, its types, and what its source says."""

import pathlib
import subprocess
import sys

import pytest

import octray


def test_the_source_alone_says_what_is_missing(tmp_path):
    source = pathlib.Path(__file__).parents[1] / "octray"
    (tmp_path / "octray").mkdir()
    for file in source.glob("*.py"):
        (tmp_path / "octray" / file.name).write_bytes(file.read_bytes())
    command = [sys.executable, "-c", "import octray"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, cwd=tmp_path)
    assert done.returncode == 1
    assert "ImportError" in done.stderr.splitlines()[-1] and "no compiled module" in done.stderr.splitlines()[-1], done


def test_the_program_is_installed():
    program = pathlib.Path(sys.executable).with_name("octray")
    done = subprocess.run([program, "--version"], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0 and done.stdout.startswith("octray ")
    done = subprocess.run([program, "no-such-file.ply"], capture_output=True, text=True, timeout=60)
    assert done.returncode == 1 and done.stderr.startswith("error: ")


def test_the_program_has_no_window(tmp_path):
    program = pathlib.Path(sys.executable).with_name("octray")
    done = subprocess.run([program, "view", "a.ply"], capture_output=True, text=True, timeout=60, cwd=tmp_path)
    assert done.returncode == 2 and done.stderr.startswith("error: this build has no window"), done
    done = subprocess.run([program, "--help"], capture_output=True, text=True, timeout=60, cwd=tmp_path)
    assert "octray info a.scn" in done.stdout
    assert "octray view" not in done.stdout and "no display" not in done.stdout


def test_names():
    assert octray.isa()
    assert "triangles" in repr(octray.Mesh([], [])) and octray.__version__


def test_types(tmp_path):
    pytest.importorskip("mypy")
    (tmp_path / "user.py").write_text(
        "import io, numpy as np, octray\n"
        "class Part(octray.Mesh): ...\n"
        "part: Part = Part.from_file('a.ply', threads=np.int64(2))\n"
        "part.all_hits([0, 0, 0], [0, 0, 1], max_hits=np.int64(3))\n"
        "octray.render(part, size=[3, 4], samples=np.int64(3), aov='depth')\n"
        "octray.render(part, size=np.array([3, 4]), camera=np.int64(2))\n"
        "octray.render(io.BytesIO(), dtype=np.float32, smooth_angle=np.float32(3), lit_from=[0, 0, 1], ground=True)\n"
        "octray.render(open('a.ply', 'rb'), animation=np.int64(1), environment='a.hdr', environment_rotate=3)\n"
        "octray.render(part, vertex_colors=np.eye(3), background='transparent', frame=np.int64(3))\n"
        "scene = octray.Scene([part], np.eye(4)[None], [0], threads=2)\n"
        "scene.move(scene.transforms * scene.closest_hit([0, 0, 0], [0, 0, 1]).instance[0])\n"
        "class Other(octray._octray.Mesh): ...\n"
    )
    command = [sys.executable, "-m", "mypy", "--cache-dir", str(tmp_path)]
    done = subprocess.run([*command, "-p", "octray"], capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stdout
    done = subprocess.run([*command, "user.py"], capture_output=True, text=True, cwd=tmp_path)
    errors = [line for line in done.stdout.splitlines() if ": error:" in line]
    assert len(errors) == 1 and "user.py:12" in errors[0] and "final" in errors[0], done.stdout
