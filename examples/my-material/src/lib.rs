//! A law of our own beside those of Fissure.

mod stiffening;

pub use stiffening::Stiffening;

use fissure_engine::Registry;

/// Fissure's laws and ours.
pub fn registry() -> Registry {
    fissure_materials::registry().bonds::<Stiffening, _>()
}
