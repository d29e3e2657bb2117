#!/usr/bin/env python3
"""Our shape matching beside pyPBD's, on the same cube of nodes, in turn.

    python3 bench/peers/shapes.py                    w = 1 and w = 2, a cube of 24 nodes, one thread: some minutes
    python3 bench/peers/shapes.py 1 --edge 32 --reps 5

pyPBD gets one cluster per node, the cube of half-width w around it, and makes one iteration in one substep. It comes from PyPI
into target/peers, our side is built by cargo. Both run after each other, again and again; figures are the least of all
runs, and the spread is that of the ratios of neighbouring runs. Beyond a step both do nothing: no contact, no gravity.
"""
import argparse
import itertools
import os
import re
import subprocess
import sys
import time
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
PLACE = ROOT / "target" / "peers"


def install():
    """A Python that has pyPBD."""
    python = PLACE / "bin" / "python"
    if not python.exists():
        venv.create(PLACE, with_pip=True)
    if subprocess.run([str(python), "-c", "import pypbd"], stderr=subprocess.DEVNULL).returncode != 0:
        print(f"installing pyPBD into {PLACE.relative_to(ROOT)}", flush=True)
        pip = [str(python), "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
        subprocess.run(pip + ["pypbd", "numpy"], check=True)
    return python


def build():
    """Our program."""
    cargo = ["cargo", "build", "--release", "--quiet", "-p", "fissure-bench", "--example", "lattice"]
    subprocess.run(cargo, check=True, cwd=ROOT)
    return Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release" / "examples" / "lattice"


def measure(edge, w, steps):
    """Runs in the Python that has pyPBD: prints nanoseconds per node and step."""
    import numpy as np
    import pypbd as pbd

    simulation = pbd.Simulation.getCurrent()
    simulation.initDefault()
    model = simulation.getModel()
    particles = model.getParticles()
    places = list(itertools.product(range(edge), repeat=3))
    number = {place: k for k, place in enumerate(places)}
    for place in places:
        # a little bent, as ours is
        particles.addVertex(np.array(place, dtype=float) * 0.01)
    around = lambda x: range(max(0, x - w), min(edge, x + w + 1))
    cluster = {p: [number[q] for q in itertools.product(*map(around, p))] for p in places}
    count = [len(cluster[p]) for p in places]  # a node is in as many clusters as its own has nodes
    for p in places:
        nodes = cluster[p]
        model.addShapeMatchingConstraint(len(nodes), nodes, [count[k] for k in nodes], 1.0)
    for k, (x, _, _) in enumerate(places):
        particles.setVelocity(k, np.array([0.0, 0.05 * np.sin(6.0 * x / edge), 0.0]))
    stepper = simulation.getTimeStep()
    stepper.setValueUInt(pbd.TimeStepController.NUM_SUB_STEPS, 1)
    stepper.setValueUInt(pbd.TimeStepController.MAX_ITERATIONS, 1)
    pbd.TimeManager.getCurrent().setTimeStepSize(0.01)
    stepper.step(model)
    start = time.process_time()
    for _ in range(steps):
        stepper.step(model)
    print(1e9 * (time.process_time() - start) / steps / len(places))


def theirs(python, edge, w, steps):
    command = [str(python), __file__, "--measure", str(w), "--edge", str(edge), "--steps", str(steps)]
    done = subprocess.run(command, env=dict(os.environ, OMP_NUM_THREADS="1"), text=True, capture_output=True)
    if done.returncode != 0:
        sys.exit(f"error: pyPBD failed:\n{done.stderr[-2000:]}")
    return float(done.stdout.split()[-1])


def ours(program, edge, w):
    command = [str(program), str(edge), f"cube of {edge}, lsm, w = {w}"]
    said = subprocess.run(command, env=dict(os.environ, RAYON_NUM_THREADS="1"), text=True, stdout=subprocess.PIPE, check=True).stdout
    return float(re.search(r"([\d.]+) ns a node", said).group(1))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("widths", nargs="*", type=int, help="half-widths of regions (1 2)")
    parser.add_argument("--edge", type=int, default=24, help="nodes along an edge")
    parser.add_argument("--reps", type=int, default=3, help="runs of each")
    parser.add_argument("--steps", type=int, default=20, help="steps of a run of pyPBD")
    parser.add_argument("--measure", type=int, help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.measure:
        return measure(args.edge, args.measure, args.steps)
    python, program = install(), build()
    print(f"{args.edge}³ nodes, one thread")
    for w in args.widths or [1, 2]:
        pairs = [(theirs(python, args.edge, w, args.steps), ours(program, args.edge, w)) for _ in range(args.reps)]
        least = [min(pair[side] for pair in pairs) for side in (0, 1)]
        ratios = sorted(a / b for a, b in pairs)
        print(
            f"w = {w}: pyPBD {least[0]:.0f} ns a node and step, ours {least[1]:.0f}: {least[0] / least[1]:.1f} × "
            f"(pairs {ratios[0]:.1f} to {ratios[-1]:.1f})",
            flush=True,
        )


if __name__ == "__main__":
    main()
