//! What holds for the whole run: title, time, gravity, integrator, seed.

use fissure_engine::params::Range;

use super::Fallback::{Required, Toml};
use super::KeyKind::{Number, NumberOr, Text, Three, Whole, Word};
use super::{ANY, Key, SHARE, of};

pub(super) const KEYS: &[Key] = &[
    of("title", Text, "", Toml("''"), "one line that says what is shown"),
    of("duration", Number(Range::POSITIVE), "s", Required, "simulated time"),
    of("gravity", Three(ANY), "m/s²", Toml("[0, -9.81, 0]"), "acceleration of everything that is not held"),
    of(
        "dt",
        NumberOr(Range::POSITIVE, "auto"),
        "s",
        Toml("'auto'"),
        "time step; \"auto\" takes the largest stable one times `safety`",
    ),
    of("safety", Number(SHARE), "1", Toml("0.8"), "share of the largest stable step that dt = \"auto\" takes"),
    of(
        "integrator",
        Word(&["symplectic_euler", "velocity_verlet", "relax"]),
        "",
        Toml("'symplectic_euler'"),
        "how forces become motion; \"relax\" makes every step an equilibrium, in which particles meet colliders but not each other, and dt = \"auto\" one step a frame",
    ),
    of(
        "residual",
        Number(Range::open(0.0, 1.0)),
        "1",
        Toml("1e-5"),
        "of \"relax\": unbalanced force that is small enough, as a share of the forces on held particles or the weight",
    ),
    of(
        "iterations",
        Whole(1, 1_000_000_000_000),
        "",
        Toml("100_000"),
        "of \"relax\": force evaluations of one step after which it is given up",
    ),
    of("seed", Whole(0, i64::MAX as u64), "", Toml("1"), "seed of every random number of the run"),
];
