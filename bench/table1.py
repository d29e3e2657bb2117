#!/usr/bin/env python3
"""Table 1 of Chen et al. with its counts of particles, on this machine: leaves `bench/results/table1.csv`.

    python3 bench/table1.py                all; a quarter of an hour on two cores
    python3 bench/table1.py fig01 bunny    scenes whose names begin so; the other rows stay as they are

Each scene is made at the paper's resolution and goes its first steps, while it is whole; that is where bonds are most and a step is
slowest, but for what contact of the fragments costs later. The paper's times are of six cores.
"""
import csv
import json
import os
import platform
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
OUT = ROOT / "bench" / "results" / "table1.csv"
STEPS = 40
# scene, what makes it the paper's size, the paper's particles, bonds, time step [s] and seconds a step
ROWS = [
    ("fig01a_glass", ["body.wall.tets=300000"], 3.0e5, 5.0e7, 1e-6, 2.4),
    ("fig01b_glass", ["body.wall.tets=300000"], 3.0e5, 5.0e7, 1e-6, 2.4),
    ("fig01c_plastic", ["body.wall.tets=300000"], 3.0e5, 5.0e7, 1e-4, 2.4),
    ("fig01d_plastic", ["body.wall.tets=300000"], 3.0e5, 5.0e7, 1e-4, 2.4),
    ("fig03_armadillo", ["body.figure.tets=420000"], 4.2e5, 7.5e7, 1e-4, 5.3),
    ("fig04_walls", ["body.elastic.tets=300000", "body.plastic.tets=300000"], 6.0e5, 1.0e8, 5e-5, 4.8),
    ("fig05_gamma", ["body.wall.tets=300000"], 3.0e5, 5.0e7, 5e-5, 2.4),
    ("fig08_jello", ["body.jello.tets=460000"], 4.6e5, 8.6e7, 5e-5, 3.8),
    ("fig11_swing", [], 9.2e3, 1.5e5, 1e-4, 0.05),
    ("fig13_stand_in", ["body.pawn.tets=20000"], 2.0e4, 1.8e6, 5e-4, 0.2),
    ("fig14_torn", ["body.figure.tets=420000"], 4.2e5, 7.5e7, 1e-4, 5.3),
    ("fig15_pressed", ["body.wall.tets=300000"], 3.0e5, 5.0e7, 1e-6, 2.4),
    ("bunny", ["body.bunny.tets=520000", "body.bunny.mesh=assets/figure.ply"], 5.2e5, 8.8e7, 5e-4, 5.2),
    ("fig17_sheet", ["body.sheet.tets=160000"], 1.6e5, 2.0e7, 5e-5, 1.8),
]
HEAD = [
    "scene", "particles", "directed_bonds", "dt_s", "s_per_step", "ns_per_bond",
    "paper_particles", "paper_bonds", "paper_dt_s", "paper_s_per_step", "times_as_fast", "per_simulated_second",
]


def told(arguments):
    """The events of a call of the program."""
    fissure = ROOT / "target" / "release" / "fissure"
    done = subprocess.run([fissure, *arguments], cwd=ROOT, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"fissure {' '.join(map(str, arguments))}: {done.stderr.strip()}")
    return [json.loads(line) for line in done.stdout.splitlines()]


def measure(scene, keys):
    """Particles, directed bonds, dt [s] and seconds a step of the first steps."""
    path = f"scenes/{scene}.toml"
    sets = [word for key in keys for word in ("--set", key)]
    about = told(["check", path, "--json", *sets])[0]
    dt = about["dt"]
    with tempfile.TemporaryDirectory() as folder:
        quiet = ["--set", f"output.frame_every={2 * STEPS * dt}", "--set", "output.export=[]"]
        events = told(["run", path, "--json", "--out", f"{folder}/run", "--until", str(STEPS * dt), *sets, *quiet])
    end = next(event for event in events if event["event"] == "end")
    count = lambda what: sum(body[what] for body in about["bodies"])
    return count("particles"), count("directed_bonds"), dt, (end["seconds"] - end["spent"]["checkpoints"]) / end["step"]


def main():
    words = sys.argv[1:]
    cargo = ["cargo", "build", "--release", "--quiet", "-p", "fissure-cli"]
    subprocess.run(cargo, cwd=ROOT, check=True)
    known = {}
    if OUT.exists():
        lines = [line for line in OUT.read_text().splitlines() if not line.startswith("#")]
        known = {row["scene"]: row for row in csv.DictReader(lines)}
    for scene, keys, particles, bonds, dt, seconds in ROWS:
        if words and not any(scene.startswith(word) for word in words):
            continue
        n, b, h, s = measure(scene, keys)
        values = [
            scene, n, b, f"{h:.3g}", f"{s:.4f}", f"{1e9 * s / b:.2f}",
            f"{particles:.2g}", f"{bonds:.2g}", f"{dt:.2g}", seconds, f"{seconds / s:.0f}", f"{seconds / s * h / dt:.0f}",
        ]
        known[scene] = dict(zip(HEAD, map(str, values)))
        print(f"{scene:16} {n} particles, {b} bonds, dt {h:.3g} s, {s:.4f} s a step, {seconds / s:.0f} times the paper's", flush=True)
    with OUT.open("w", newline="") as file:
        model = next((line.split(":")[1].strip() for line in open("/proc/cpuinfo") if "model name" in line), platform.machine())
        file.write(f"# {model}, {os.cpu_count()} threads; the paper's are of six cores; bonds are directed in both\n")
        table = csv.DictWriter(file, HEAD)
        table.writeheader()
        table.writerows(known[row[0]] for row in ROWS if row[0] in known)


if __name__ == "__main__":
    main()
