//! The constitutive laws that come with Fissure, one file each, the list that registers them, and
//! [`conformance`], the checks that every law must pass.

pub mod conformance;
mod isotropic;
pub mod moduli;

pub use isotropic::Isotropic;

use fissure_engine::Registry;

/// Every material of this crate. Your own crate starts from it: `registry().bonds::<Mine, _>()`.
pub fn registry() -> Registry {
    Registry::default().bonds::<Isotropic, _>()
}
