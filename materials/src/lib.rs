//! The constitutive laws that come with Fissure, one file each, the
//! [`lattice`] of shape matching, the list that registers them, and
//! [`conformance`], the checks that every law must pass.

pub mod anisotropic;
pub mod conformance;
mod isotropic;
pub mod lattice;
mod lps;
mod mitchell;
pub mod moduli;
mod plastic;
mod pmb;
mod taper;
mod viscoelastic;
pub mod yielding;

pub use anisotropic::Anisotropic;
pub use isotropic::Isotropic;
pub use lps::Lps;
pub use mitchell::Mitchell;
pub use plastic::Plastic;
pub use pmb::Pmb;
pub use viscoelastic::Viscoelastic;

use fissure_engine::Registry;

/// Every material of this crate. Your own crate starts from it: `registry().bonds::<Mine, _>()`.
pub fn registry() -> Registry {
    let bonds = Registry::default()
        .bonds::<Isotropic, _>()
        .bonds::<Plastic, _>()
        .bonds::<Anisotropic<Isotropic>, _>()
        .bonds::<Anisotropic<Plastic<true>>, _>()
        .bonds::<Viscoelastic, _>()
        .bonds::<Lps, _>()
        .bonds::<Mitchell, _>()
        .bonds::<Pmb, _>();
    lattice::register(bonds)
}
