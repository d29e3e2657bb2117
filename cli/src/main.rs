//! The program `fissure`: a thin shell around the library.

fn main() -> std::process::ExitCode {
    fissure_cli::main_with(fissure_materials::registry())
}
