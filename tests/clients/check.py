#!/usr/bin/env python3
"""Opens the exports of a small run with other people's programs and says what is wrong.

    python3 tests/clients/check.py [FISSURE] [--pictures DIR]

Runs a short drop of scenes/vase.toml with every format, then asks each client that is there: Pixar's USD (`pip install
usd-core`), pyvista and meshio (`pip install pyvista meshio`), Khronos' validator (`npm install gltf-validator` in the folder
from which this is called), POV-Ray, f3d, ParaView (with python3-paraview) and Blender (`pip install bpy`). Clients that are missing are skipped with a line.
Prints a line a client and exits 1 where anything is wrong.
"""
import argparse
import importlib.util
import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FORMATS = ["usd", "vtu", "ply", "obj", "glb", "pov"]
wrong = []


def expect(holds, what):
    if not holds:
        wrong.append(what)
        print("  WRONG:", what)


def python_has(module):
    found = importlib.util.find_spec(module) is not None
    if not found:
        print(f"{module}: not installed, skipped")
    return found


def call(*command, **options):
    return subprocess.run([str(c) for c in command], capture_output=True, text=True, **options)


def usd(run, frames):
    """Validators, then at each frame what they do not look at: counts, indices, lengths of every column."""
    from pxr import Gf, Usd, UsdGeom, UsdShade, UsdValidation

    stage = Usd.Stage.Open(str(run / "usd/stage.usda"))
    everything = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    for error in UsdValidation.ValidationContext(everything).Validate(stage):
        expect(False, f"usd: {error.GetErrorAsString()}")
    expect(stage.GetEndTimeCode() - stage.GetStartTimeCode() + 1 == frames, "usd: a frame is missing")
    expect(stage.GetDefaultPrim().GetPath() == "/run" and UsdGeom.GetStageUpAxis(stage) == "Y", "usd: head of the stage")
    times = range(int(stage.GetStartTimeCode()), int(stage.GetEndTimeCode()) + 1)
    growth = []
    for path in ["/run/outside", "/run/inside"]:
        mesh = UsdGeom.Mesh.Get(stage, path)
        material, _ = UsdShade.MaterialBindingAPI(mesh).ComputeBoundMaterial()
        expect(bool(material), f"usd: {path} has no material")
        for t in times:
            points, velocities = mesh.GetPointsAttr().Get(t), mesh.GetVelocitiesAttr().Get(t)
            counts, indices = mesh.GetFaceVertexCountsAttr().Get(t), mesh.GetFaceVertexIndicesAttr().Get(t)
            expect(len(points) == len(velocities) == len(mesh.GetNormalsAttr().Get(t)), f"usd: columns of {path} at {t}")
            expect(UsdGeom.Mesh.ValidateTopology(indices, counts, len(points))[0], f"usd: indices of {path} at {t}")
            for name in ["damage", "stretch", "id", "inside", "piece"]:
                column = UsdGeom.PrimvarsAPI(mesh).GetPrimvar(name)
                good = column.GetInterpolation() == "vertex" and len(column.Get(t)) == len(points)
                expect(good, f"usd: {name} of {path} at {t}")
            low, high = mesh.GetExtentAttr().Get(t)
            box = Gf.Range3f(low, high)
            expect(all(box.Contains(p) for p in points), f"usd: extent of {path} at {t}")
        growth.append(len(mesh.GetFaceVertexCountsAttr().Get(times[-1])))
    dots = UsdGeom.Points.Get(stage, "/run/particles")
    ids = dots.GetIdsAttr().Get(times[-1])
    expect(len(set(ids)) == len(ids) == len(dots.GetWidthsAttr().Get(times[-1])), "usd: ids of particles")
    expect(min(growth) > 100, "usd: nothing broke")
    print(f"usd-core {'.'.join(map(str, Usd.GetVersion()))}: {frames} frames, {growth} triangles outside and inside")


def vtk(run, frames):
    import numpy as np
    import pyvista as pv

    for part, arrays in {
        "surface": {"Normals", "velocity", "damage", "stretch", "id", "inside", "piece"},
        "particles": {"velocity", "damage", "id", "piece", "body", "mass", "volume", "width"},
        "tets": {"velocity", "damage", "id", "piece", "body"},
    }.items():
        reader = pv.get_reader(str(run / f"vtu/{part}.pvd"))
        times = reader.time_values
        expect(len(times) == frames and np.all(np.diff(times) > 0), f"pyvista: times of {part}")
        for time in times:
            reader.set_active_time_value(time)
            grid = reader.read()[0]
            expect(set(grid.array_names) == arrays, f"pyvista: {part} has {grid.array_names}")
            expect(np.isfinite(grid.points).all() and grid.n_cells > 0, f"pyvista: {part} at {time} s")
        print(f"pyvista {pv.__version__}: {part}, {len(times)} times, {grid.n_points} points and {grid.n_cells} cells at last")
    coloured = pv.read(run / f"ply/frame_{frames - 1:04}.ply")
    expect(len(np.unique(coloured["RGB"], axis=0)) == 2, "pyvista: two colours in PLY")


def meshio(run, frames):
    import meshio

    last = f"frame_{frames - 1:04}"
    for name, kind in [("surface", "triangle"), ("particles", "vertex"), ("tets", "tetra")]:
        mesh = meshio.read(run / f"vtu/{name}/{last}.vtu")
        expect(mesh.cells[0].type == kind and "velocity" in mesh.point_data, f"meshio: {name}.vtu")
    ply = meshio.read(run / f"ply/{last}.ply")
    obj = meshio.read(run / f"obj/{last}.obj")
    triangles = [sum(len(c.data) for c in mesh.cells) for mesh in (ply, obj)]
    expect(len(ply.points) == len(obj.points) and triangles[0] == triangles[1], f"meshio: triangles {triangles}")
    print(f"meshio {meshio.__version__}: VTU, PLY and OBJ with {triangles[0]} triangles")


VALIDATE = """
const validator = require('gltf-validator'), fs = require('fs');
validator.validateBytes(new Uint8Array(fs.readFileSync(process.argv[1]))).then(r => console.log(JSON.stringify(r)));
"""


def gltf(run):
    answer = call("node", "-e", VALIDATE, run / "run.glb") if shutil.which("node") else None
    if answer is None or answer.returncode:
        return print("gltf-validator: not installed here, skipped")
    report = json.loads(answer.stdout)
    for message in report["issues"]["messages"]:
        expect(False, f"gltf-validator: {message['code']} at {message['pointer']}")
    info = report["info"]
    print(f"gltf-validator {report['validatorVersion']}: {info['totalTriangleCount']} triangles, {info['drawCallCount']} draws")


def povray(run, frames, pictures):
    if not shutil.which("povray"):
        return print("povray: not installed, skipped")
    picture = pictures / "povray.png"
    answer = call("povray", f"+Iframe_{frames - 1:04}.pov", f"+O{picture}", "+W640", "+H360", "-D", cwd=run / "pov")
    expect(answer.returncode == 0 and picture.exists(), f"povray: {answer.stderr[-300:]}")
    print(f"povray: {picture}")


def f3d(run, frames, pictures):
    if not (shutil.which("f3d") and shutil.which("xvfb-run")):
        return print("f3d with xvfb-run: not installed, skipped")
    last = f"frame_{frames - 1:04}"
    for file in [f"ply/{last}.ply", f"obj/{last}.obj", f"vtu/surface/{last}.vtu", "run.glb"]:
        picture = pictures / f"f3d_{Path(file).suffix[1:]}.png"
        answer = call("xvfb-run", "-a", "f3d", f"--output={picture}", "--resolution=640,480", run / file)
        expect(answer.returncode == 0 and picture.exists(), f"f3d: {file}: {answer.stderr[-300:]}")
    print(f"f3d: {pictures}/f3d_*.png")


PARAVIEW = """
import sys
from paraview.simple import *
folder, picture = sys.argv[1:]
reader = PVDReader(FileName=folder + '/surface.pvd')
times = list(reader.TimestepValues)
view = CreateView('RenderView')
shown = Show(reader, view)
ColorBy(shown, ('POINTS', 'damage'))
view.ViewTime = times[-1]
ResetCamera(view)
Render(view)
SaveScreenshot(picture, view, ImageResolution=[640, 480])
reader.UpdatePipeline(times[-1])
info = reader.GetDataInformation()
print(len(times), info.GetNumberOfPoints(), sorted(reader.PointData.keys()))
"""


def paraview(run, frames, pictures):
    if not (shutil.which("pvbatch") and shutil.which("xvfb-run")):
        return print("ParaView (pvbatch) with xvfb-run: not installed, skipped")
    script, picture = run / "look.py", pictures / "paraview.png"
    script.write_text(PARAVIEW)
    answer = call("xvfb-run", "-a", "pvbatch", "--force-offscreen-rendering", script, run / "vtu", picture)
    expect(answer.returncode == 0 and picture.exists(), f"ParaView: {answer.stderr[-300:]}")
    expect(answer.stdout.startswith(f"{frames} ") and "'velocity'" in answer.stdout, f"ParaView: {answer.stdout}")
    print(f"ParaView: {answer.stdout.strip()}")


def blender(run, frames, pictures):
    import bpy
    import mathutils

    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.usd_import(filepath=str(run / "usd/stage.usda"), import_guide=True)
    scene = bpy.context.scene
    meshes = [o for o in bpy.data.objects if o.type == "MESH"]
    expect({o.name for o in meshes} == {"outside", "inside"}, f"blender: {[o.name for o in meshes]}")
    dots = [o for o in bpy.data.objects if o.type == "POINTCLOUD"]
    expect(len(dots) == 1, "blender: no particles")
    for item in dots:
        names = {a.name for a in item.data.attributes}
        expect({"velocity", "radius", "damage", "piece", "body", "mass"} <= names, f"blender: particles keep {names}")
        item.hide_render = True  # they would stick out of the surface
    low = mathutils.Vector((1e9,) * 3)
    high = -low
    for frame in (0, frames - 1):
        scene.frame_set(frame)
        graph = bpy.context.evaluated_depsgraph_get()
        for item in meshes:
            mesh = item.evaluated_get(graph).to_mesh()
            names = {a.name for a in mesh.attributes}
            # a mesh without faces, as that of the cracks is at first, keeps no columns
            names |= {"damage", "stretch", "id", "inside", "piece"} if not mesh.polygons else set()
            expect({"velocity", "damage", "stretch", "id", "inside", "piece"} <= names, f"blender: {item.name} keeps {names}")
            expect(item.material_slots[0].material.name == item.name, f"blender: material of {item.name}")
            for vertex in mesh.vertices if item.name == "outside" else []:
                place = item.matrix_world @ vertex.co
                low = mathutils.Vector(map(min, low, place))
                high = mathutils.Vector(map(max, high, place))
            if frame > 0:
                print(f"blender {bpy.app.version_string}: {item.name}, {len(mesh.polygons)} faces at frame {frame}")
    middle, size = (low + high) / 2, (high - low).length
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location = middle + mathutils.Vector((0.3, -0.9, 0.4)) * size
    camera.rotation_euler = (middle - camera.location).to_track_quat("-Z", "Y").to_euler()
    sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    sun.data.energy, sun.rotation_euler = 4, (0.6, 0.3, 0)
    scene.collection.objects.link(camera)
    scene.collection.objects.link(sun)
    scene.camera, scene.world = camera, bpy.data.worlds.new("world")
    scene.render.engine, scene.cycles.device, scene.cycles.samples = "CYCLES", "CPU", 16
    scene.render.fps = 240  # blur is velocity over frame rate: that of the run, not of the film
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 1.0
    scene.render.resolution_x, scene.render.resolution_y = 640, 400
    scene.render.filepath = str(pictures / "blender.png")
    bpy.ops.render.render(write_still=True)
    expect((pictures / "blender.png").exists(), "blender: no picture")


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("fissure", nargs="?", default="fissure", help="the program [fissure]")
    arguments.add_argument("--pictures", type=Path, help="keep the pictures in this folder")
    given = arguments.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        run = Path(folder) / "run"
        pictures = given.pictures.resolve() if given.pictures else Path(folder)
        pictures.mkdir(parents=True, exist_ok=True)
        sets = ["body.vase.tets=6000", "duration=0.04", f"output.export={json.dumps(FORMATS)}"]
        command = [given.fissure, "run", ROOT / "scenes/vase.toml", "--out", run, "--quiet"]
        answer = call(*command, *(word for key in sets for word in ("--set", key)))
        if answer.returncode:
            sys.exit(answer.stderr)
        frames = len(list((run / "frames").iterdir()))
        if python_has("pxr"):
            usd(run, frames)
        if python_has("pyvista"):
            vtk(run, frames)
        if python_has("meshio"):
            meshio(run, frames)
        gltf(run)
        povray(run, frames, pictures)
        f3d(run, frames, pictures)
        paraview(run, frames, pictures)
        if python_has("bpy"):
            blender(run, frames, pictures)
    print(f"{len(wrong)} wrong")
    sys.exit(1 if wrong else 0)


main()
