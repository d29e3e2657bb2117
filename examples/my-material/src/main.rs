//! The whole program `fissure` with our law in it.

fn main() -> std::process::ExitCode {
    fissure_cli::main_with(my_material::registry())
}
