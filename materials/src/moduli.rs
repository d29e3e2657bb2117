//! Elastic moduli: κ and μ, or E and ν, and what each pair means.

use fissure_engine::{Kind, ParamError, Parameter, Params, Range};

/// Bulk modulus κ.
pub const BULK: Parameter = Parameter {
    name: "bulk_modulus",
    unit: "Pa",
    kind: Kind::OptionalNumber(Range::POSITIVE),
    about: "bulk modulus κ; with `shear_modulus`, or give `young_modulus` and `poisson_ratio`",
};
/// Shear modulus μ.
pub const SHEAR: Parameter = Parameter {
    name: "shear_modulus",
    unit: "Pa",
    kind: Kind::OptionalNumber(Range::POSITIVE),
    about: "shear modulus μ; with `bulk_modulus`",
};
/// Young's modulus E.
pub const YOUNG: Parameter = Parameter {
    name: "young_modulus",
    unit: "Pa",
    kind: Kind::OptionalNumber(Range::POSITIVE),
    about: "Young's modulus E; with `poisson_ratio`",
};
/// Poisson's ratio ν.
pub const POISSON: Parameter = Parameter {
    name: "poisson_ratio",
    unit: "1",
    kind: Kind::OptionalNumber(Range::open(-1.0, 0.5)),
    about: "Poisson's ratio ν; with `young_modulus`",
};

/// Bulk and shear modulus (κ, μ) [Pa] from whichever pair is given.
///
/// # Errors
/// Neither pair, or parts of both.
pub fn bulk_and_shear(p: &Params) -> Result<(f64, f64), ParamError> {
    let get = |parameter: &Parameter| p.optional(parameter.name);
    match (get(&BULK), get(&SHEAR), get(&YOUNG), get(&POISSON)) {
        (Some(k), Some(g), None, None) => Ok((k, g)),
        (None, None, Some(e), Some(nu)) => Ok((e / (3.0 * (1.0 - 2.0 * nu)), e / (2.0 * (1.0 + nu)))),
        _ => Err(ParamError::new(
            p.given_of(&[BULK.name, SHEAR.name, YOUNG.name, POISSON.name]),
            "give either `bulk_modulus` and `shear_modulus` [Pa], or `young_modulus` [Pa] and `poisson_ratio`".into(),
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fissure_engine::Value;

    fn read(pairs: &[(&str, f64)]) -> Result<(f64, f64), ParamError> {
        let given = pairs.iter().map(|(k, v)| (k.to_string(), Value::Number(*v))).collect();
        Params::new(vec![BULK, SHEAR, YOUNG, POISSON], given).and_then(|p| bulk_and_shear(&p))
    }

    #[test]
    fn both_pairs_mean_the_same_solid() {
        // κ = E/3(1 − 2ν), μ = E/2(1 + ν): E = 3, ν = ¼ gives 2 and 1.2
        let (k, g) = read(&[("young_modulus", 3.0), ("poisson_ratio", 0.25)]).unwrap();
        assert!((k - 2.0).abs() < 1e-15 && (g - 1.2).abs() < 1e-15);
        assert_eq!(read(&[("bulk_modulus", 2.0), ("shear_modulus", 1.2)]).unwrap(), (2.0, 1.2));
    }

    #[test]
    fn half_a_pair_or_an_impossible_ratio_is_refused() {
        assert!(read(&[("bulk_modulus", 2.0)]).unwrap_err().message.contains("either"));
        assert!(read(&[("bulk_modulus", 2.0), ("poisson_ratio", 0.2)]).is_err());
        let message = read(&[("young_modulus", 3.0), ("poisson_ratio", 0.5)]).unwrap_err().message;
        assert!(message.contains("poisson_ratio") && message.contains("(-1, 0.5)"), "{message}");
    }
}
