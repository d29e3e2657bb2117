//! What a scene says about a lattice.

use fissure_engine::{Kind, ParamError, Parameter, Params, Range};

/// Which regions are matched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// One region per node of an adaptive lattice, with β of Eq. 10 (Ohta et al.).
    Ohta,
    /// One region per node of the uniform lattice (Rivers and James 2007).
    Uniform,
    /// One region for each connected piece (Müller et al. 2005).
    Single,
    /// Overlapping cubes of 2w + 2 cells, eight over each cell (Müller et al. 2005).
    Clustered,
    /// As Ohta without β (Steinemann et al. 2008).
    Steinemann,
}

const METHODS: [(&str, Method); 5] = [
    ("ohta", Method::Ohta),
    ("lsm", Method::Uniform),
    ("single", Method::Single),
    ("clustered", Method::Clustered),
    ("steinemann", Method::Steinemann),
];

/// When and how a region's rest shape flows (Müller et al. 2005, Sec. 4.5).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plastic {
    /// ‖S − 1‖ beyond which it flows [1].
    pub threshold: f64,
    /// How fast [1/s].
    pub creep: f64,
    /// Largest ‖Sᵖ − 1‖ [1].
    pub cap: f64,
}

/// What a lattice is told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Which regions.
    pub method: Method,
    /// Whether β is that of Eq. 10, which knows w and mass only, or follows from how far regions reach.
    pub as_written: bool,
    /// w, how many links a region reaches from its node's cells.
    pub half_width: u32,
    /// α of one reference step [1].
    pub stiffness: f64,
    /// That step [s].
    pub reference_step: f64,
    /// Coarser levels above the finest; 0 for a uniform lattice.
    pub levels: u32,
    /// Least share of a coarse cell that must be solid for its children to be merged [1].
    pub fill: f64,
    /// |S_ii − 1| beyond which a node is replaced by its children [1].
    pub subdivide_at: f64,
    /// |S_ii − 1| below which siblings are merged again [1]; below 0 where they never are.
    pub merge_below: f64,
    /// Goal passes in a step.
    pub passes: u32,
    /// Which share of the coming step goals foresee [1].
    pub damping: f64,
    /// Whether A is scaled to keep the volume.
    pub volume_preserving: bool,
    /// How the rest shape flows, if it does.
    pub plastic: Option<Plastic>,
    /// Stretch at which a link between two finest nodes breaks [1]; infinite for never.
    pub critical_stretch: f64,
}

impl Default for Settings {
    fn default() -> Self {
        let given = Params::new(PARAMETERS.to_vec(), Vec::new()).expect("every parameter has a default");
        Self::new(&given, f64::INFINITY).expect("defaults are in range")
    }
}

const fn number(name: &'static str, unit: &'static str, range: Range, default: f64, about: &'static str) -> Parameter {
    Parameter { name, unit, kind: Kind::NumberOr(range, default), about }
}

const SHARE: Range = Range { low: (0.0, false), high: (1.0, true) };

/// The parameters of the material.
pub const PARAMETERS: &[Parameter] = &[
    Parameter {
        name: "method",
        unit: "1",
        kind: Kind::Word(&["ohta", "lsm", "single", "clustered", "steinemann"]),
        about: "adaptive with stiffness adjustment (Ohta et al.), uniform (Rivers and James 2007), one region or \
                overlapping ones (Müller et al. 2005), adaptive without adjustment (Steinemann et al. 2008)",
    },
    Parameter {
        name: "formulation",
        unit: "1",
        kind: Kind::Word(&["default", "as_written"]),
        about: "β from how far the nodes of a region spread against those of its finest cells, or Eq. 10 as printed",
    },
    number(
        "half_width",
        "1",
        Range::closed(1.0, 16.0),
        1.0,
        "w, a whole number: how many cells a region reaches beyond its own",
    ),
    number(
        "stiffness",
        "1",
        SHARE,
        0.5,
        "α of Eq. 3: which share of the way to its goal a node goes in one reference step",
    ),
    number(
        "reference_step",
        "s",
        Range::POSITIVE,
        0.01,
        "the step that `stiffness` is meant for; others do as much in the same time",
    ),
    number(
        "levels",
        "1",
        Range::closed(0.0, 10.0),
        2.0,
        "a whole number: coarser levels above the finest cells; 0 is a uniform lattice",
    ),
    number(
        "fill",
        "1",
        Range::closed(0.0, 1.0),
        0.5,
        "share of a coarse cell that must be solid for its cells to be merged",
    ),
    number(
        "subdivide_at",
        "1",
        Range::POSITIVE,
        0.1,
        "stretch |S_ii - 1| of its region beyond which a coarse node is subdivided",
    ),
    Parameter {
        name: "merge",
        unit: "1",
        kind: Kind::Word(&["yes", "no"]),
        about: "whether connected siblings are merged when they are calm, also after fracture",
    },
    number(
        "merge_below",
        "1",
        Range::NOT_NEGATIVE,
        0.03,
        "stretch |S_ii - 1| below which siblings are merged; less than `subdivide_at`",
    ),
    number(
        "passes",
        "1",
        Range::closed(1.0, 100.0),
        1.0,
        "a whole number: goal passes in a step; forces travel one region further in each",
    ),
    number(
        "damping",
        "1",
        Range::closed(0.0, 1.0),
        0.0,
        "which share of the coming step goals foresee; it takes energy from swinging, and momentum from nothing; 0 is Eq. 3",
    ),
    Parameter {
        name: "volume_preserving",
        unit: "1",
        kind: Kind::Word(&["no", "yes"]),
        about: "whether A of Eq. 5 is scaled to det A = 1",
    },
    Parameter {
        name: "yield_strain",
        unit: "1",
        kind: Kind::OptionalNumber(Range::POSITIVE),
        about: "‖S − 1‖ of a region beyond which its rest shape flows (Müller et al. 2005); left out, it never does",
    },
    number(
        "creep",
        "1/s",
        Range::POSITIVE,
        10.0,
        "how fast the rest shape flows to the present one beyond `yield_strain`",
    ),
    Parameter {
        name: "plastic_cap",
        unit: "1",
        kind: Kind::OptionalNumber(Range::POSITIVE),
        about: "largest ‖Sᵖ − 1‖ that the rest shape flows to; left out, there is no limit",
    },
];

/// The parameter of the criterion `critical_stretch`.
pub const FRACTURE: &[Parameter] = &[Parameter {
    name: "critical_stretch",
    unit: "1",
    kind: Kind::Number(Range::POSITIVE),
    about: "a link between two of the 26 neighbours at the finest level breaks where their distance has grown by this share \
            of the one at rest, or of the cell where that is longer",
}];

impl Settings {
    /// Reads the parameters; links break at `critical_stretch` [1].
    ///
    /// # Errors
    /// Numbers that must be whole and are not, `merge_below` that is not below `subdivide_at`.
    pub fn new(p: &Params, critical_stretch: f64) -> Result<Self, ParamError> {
        let method = METHODS.iter().find(|(word, _)| *word == p.word("method")).expect("the table has all words").1;
        let adaptive = matches!(method, Method::Ohta | Method::Steinemann);
        let (subdivide_at, below) = (p.number("subdivide_at"), p.number("merge_below"));
        if below >= subdivide_at {
            let key = p.given_of(&["merge_below", "subdivide_at"]);
            let message = format!(
                "`merge_below` = {below} must be less than `subdivide_at` = {subdivide_at}, or nodes would split and merge in turn"
            );
            return Err(ParamError::new(key, message));
        }
        let plastic = p.optional("yield_strain").map(|threshold| Plastic {
            threshold,
            creep: p.number("creep"),
            cap: p.optional("plastic_cap").unwrap_or(f64::INFINITY),
        });
        let levels = whole(p, "levels")?;
        Ok(Self {
            method,
            as_written: p.word("formulation") == "as_written",
            half_width: whole(p, "half_width")?,
            stiffness: p.number("stiffness"),
            reference_step: p.number("reference_step"),
            levels: if adaptive { levels } else { 0 },
            fill: p.number("fill"),
            subdivide_at,
            merge_below: if p.word("merge") == "yes" { below } else { -1.0 },
            passes: whole(p, "passes")?,
            damping: p.number("damping"),
            volume_preserving: p.word("volume_preserving") == "yes",
            plastic,
            critical_stretch,
        })
    }

    /// α of one pass in a step of `h` [s]: all passes of a reference step together go `stiffness` of the way.
    pub fn share(&self, h: f64) -> f64 {
        let steps = h / self.reference_step / f64::from(self.passes);
        -f64::exp_m1(steps * f64::ln_1p(-self.stiffness))
    }

    /// Whether links may break.
    pub fn breaks(&self) -> bool {
        self.critical_stretch.is_finite()
    }

    /// Whether there is one region for each node, around it.
    pub fn per_node(&self) -> bool {
        !matches!(self.method, Method::Single | Method::Clustered)
    }
}

/// A number that must be whole.
fn whole(p: &Params, key: &str) -> Result<u32, ParamError> {
    let value = p.number(key);
    if value.fract() == 0.0 {
        return Ok(value as u32);
    }
    Err(ParamError::new(key, format!("`{key}` = {value} must be a whole number")))
}

#[cfg(test)]
mod tests {
    use fissure_engine::Value;

    use super::*;

    fn given(pairs: &[(&str, f64)]) -> Result<Settings, ParamError> {
        let pairs = pairs.iter().map(|(k, v)| (k.to_string(), Value::Number(*v))).collect();
        Settings::new(&Params::new(PARAMETERS.to_vec(), pairs)?, f64::INFINITY)
    }

    #[test]
    fn half_steps_and_passes_go_as_far_together() {
        let s = given(&[("stiffness", 0.3), ("passes", 3.0)]).unwrap();
        for (h, times) in [(0.01, 3), (0.005, 6), (0.02, 1)] {
            let left = (1.0 - s.share(h)).powi(times);
            let want = 0.7_f64.powf(h / 0.01 * f64::from(times) / 3.0);
            assert!((left - want).abs() < 1e-14, "{h}: {left} instead of {want}");
        }
        assert_eq!(given(&[("stiffness", 1.0)]).unwrap().share(1e-6), 1.0);
    }

    #[test]
    fn bad_numbers_get_a_sentence() {
        let message = |pairs: &[(&str, f64)]| given(pairs).unwrap_err().message;
        assert_eq!(message(&[("half_width", 1.5)]), "`half_width` = 1.5 must be a whole number");
        assert!(message(&[("half_width", 0.0)]).contains("must be in [1, 16]"));
        assert!(message(&[("stiffness", 0.0)]).contains("must be in (0, 1]"));
        assert!(
            message(&[("merge_below", 0.2)]).starts_with("`merge_below` = 0.2 must be less than `subdivide_at` = 0.1")
        );
        assert_eq!(Settings::default().method, Method::Ohta);
    }
}
