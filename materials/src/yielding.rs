//! When a bond yields: a stress, a stretch or Ψ0, and which stretch each of them means.

use std::f64::consts::PI;

use fissure_engine::{Kind, ParamError, Parameter, Params, Range};

/// The least yield stretch: the stable step is measured at stretches of 1e-6, which must be elastic.
const LEAST: f64 = 1e-5;

const fn optional(name: &'static str, unit: &'static str, about: &'static str) -> Parameter {
    Parameter { name, unit, kind: Kind::OptionalNumber(Range::POSITIVE), about }
}

/// σ_y, tensile stress of first yield.
pub const STRESS: Parameter =
    optional("yield_stress", "Pa", "tensile stress σ_y of first yield, 3μ times `yield_stretch`; give one of the two");
/// s_y, elastic deviatoric stretch at yield.
pub const STRETCH: Parameter =
    optional("yield_stretch", "1", "deviatoric stretch s_y at which a bond yields; or give `yield_stress`");
/// Ψ0 of Eq. 13.
pub const PSI0: Parameter =
    optional("psi0", "N^2/m^12", "Ψ0 of Eq. 13, only as_written: means another stretch at every horizon");
/// γ/|ξ| of Eq. 16.
pub const CAP: Parameter =
    optional("plastic_cap", "1", "largest plastic stretch γ/|ξ| of a bond (Eq. 16); left out, there is no limit");

/// The yield stretch s_y, a pure number, of a solid with shear modulus `mu` in Pa at horizon `delta` in m.
///
/// # Errors
/// None of the parameters, several, `psi0` where it means nothing, or a stretch below 1e-5.
pub fn stretch(p: &Params, mu: f64, delta: f64, as_written: bool) -> Result<f64, ParamError> {
    let get = |parameter: &Parameter| p.optional(parameter.name);
    let (key, stretch) = match (get(&STRESS), get(&STRETCH), get(&PSI0)) {
        (Some(stress), None, None) => (STRESS.name, stress / (3.0 * mu)),
        (None, Some(stretch), None) => (STRETCH.name, stretch),
        // √(2Ψ0) = 4ωb s_y|ξ| (Eqs. 10, 12, 14)
        (None, None, Some(psi)) if as_written => (PSI0.name, PI * delta.powi(4) * (2.0 * psi).sqrt() / (30.0 * mu)),
        _ => {
            let message =
                "give either `yield_stress` [Pa] or `yield_stretch`, or `psi0` with formulation = \"as_written\"";
            return Err(ParamError::new(p.given_of(&[STRESS.name, STRETCH.name, PSI0.name]), message.into()));
        }
    };
    if stretch < LEAST {
        let message = format!("`{key}` means yield at a stretch of {stretch:.1e}; it must be {LEAST:.0e} or more");
        return Err(ParamError::new(key, message));
    }
    Ok(stretch)
}
