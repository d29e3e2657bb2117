//! The lattice: what it keeps, whatever the method.

mod body;
mod compare;
mod run;
mod update;
