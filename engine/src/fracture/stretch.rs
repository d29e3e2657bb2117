//! Critical stretch with damage dependence.

use super::toughening::{ALPHA, READING, Toughening};
use super::{Bulk, Criterion, Opening};
use crate::lane::Lane;
use crate::law::Surroundings;
use crate::params::{Kind, ParamError, Parameter, Params, Range};

/// A bond breaks where s^ω exceeds `critical_stretch` (Chen et al., Eqs. 18–19). Only tension breaks a bond.
///
/// The law decides what is stretch: for the laws of the paper s^ω = s^e/ω = (e − e^p)/(ω |ξ|), which is extension over
/// horizon where ω = δ/|ξ|; for the standard solids e/|ξ|.
pub struct CriticalStretch(Toughening);

impl Criterion for CriticalStretch {
    const NAME: &'static str = "critical_stretch";
    const SUMMARY: &'static str = "a bond breaks beyond a critical elastic stretch (Chen et al., Eqs. 18-19)";
    const PARAMETERS: &'static [Parameter] = &[
        Parameter {
            name: "critical_stretch",
            unit: "1",
            kind: Kind::Number(Range::POSITIVE),
            about: "the s^ω of Eq. 19 beyond which a bond breaks; with ω = δ/|ξ| that is extension over horizon",
        },
        ALPHA,
        READING,
    ];

    fn from_params(p: &Params, _: &Surroundings, _: &Bulk) -> Result<Self, ParamError> {
        Ok(Self(Toughening::new(p.number("critical_stretch"), p)))
    }

    #[inline(always)]
    fn severity<L: Lane>(&self, b: &Opening<L>, damage: L) -> L {
        self.0.severity(b.stretch(), damage)
    }

    #[inline(always)]
    fn suspects<L: Lane>(&self, b: &Opening<L>) -> L::Mask {
        b.elastic.above(L::of(self.0.least()) * b.gauge)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::Value;

    fn criterion(more: &[(&str, Value)]) -> CriticalStretch {
        let mut given = vec![("critical_stretch".to_string(), Value::Number(0.1))];
        given.extend(more.iter().map(|(k, v)| (k.to_string(), v.clone())));
        let p = Params::new(CriticalStretch::PARAMETERS.to_vec(), given).unwrap();
        CriticalStretch::from_params(&p, &Surroundings { horizon: 2.0, spacing: 1.0 }, &Bulk::default()).unwrap()
    }

    fn opening(elastic: f64) -> Opening<f64> {
        Opening { rest: 1.0, elastic, gauge: 2.0, theta: 0.0 }
    }

    #[test]
    fn stretch_is_extension_over_gauge_and_compression_never_breaks() {
        let c = criterion(&[]);
        assert!((c.severity(&opening(0.3), 0.0) - 1.5).abs() < 1e-15);
        assert!(c.severity(&opening(-5.0), 0.0) < 0.0 && !c.suspects(&opening(-5.0)));
    }

    #[test]
    fn damage_toughens_by_default_and_weakens_as_written() {
        let alpha = ("alpha", Value::Number(2.0));
        assert!((criterion(std::slice::from_ref(&alpha)).severity(&opening(0.3), 0.5) - 0.75).abs() < 1e-15);
        let written = criterion(&[alpha, ("alpha_reading", Value::Word("as_written".into()))]);
        assert!((written.severity(&opening(0.3), 0.5) - 3.0).abs() < 1e-15);
    }

    #[test]
    fn whatever_breaks_at_some_damage_is_suspected() {
        for reading in ["divide", "as_written"] {
            let c = criterion(&[("alpha", Value::Number(1.5)), ("alpha_reading", Value::Word(reading.into()))]);
            for k in 0..400 {
                let b = opening(f64::from(k) * 1e-3 + 5e-4);
                let worst = [0.0, 0.3, 1.0].map(|d| c.severity(&b, d)).into_iter().fold(0.0, f64::max);
                assert_eq!(c.suspects(&b), worst > 1.0, "{reading}: {b:?}");
            }
        }
    }
}
