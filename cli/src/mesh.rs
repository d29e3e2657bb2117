//! `fissure mesh`: tetrahedra from a surface with their quality, or one format to another.

use std::process::ExitCode;
use std::time::Instant;

use fissure_io::mesh::{LabelledTets, Mesh, read, write};
use fissure_io::scene::Resolution;
use fissure_io::simulation::fill;
use fissure_meshing::quality::Report;

use crate::Error;
use crate::args::MeshArgs;

pub(crate) fn command(options: &MeshArgs) -> Result<ExitCode, Error> {
    let surface_out = options.output.extension().is_some_and(|e| {
        let e = e.to_string_lossy().to_lowercase();
        ["obj", "ply", "stl"].contains(&e.as_str())
    });
    let mesh = match read(&options.input)? {
        Mesh::Surface(surface) if !surface_out => {
            for (name, value) in [("size", options.size), ("shell", options.shell)] {
                if value.is_some_and(|v| !(v > 0.0 && v.is_finite())) {
                    return Err(Error::Usage(format!("--{name} must be above 0 [m]")));
                }
            }
            let resolution = match options.size {
                Some(size) => Resolution::Size(size),
                None => Resolution::Tets(options.tets.unwrap_or(20_000)),
            };
            let start = Instant::now();
            let solid = fill(surface, resolution, options.shell, options.seed)
                .map_err(|e| Error::Usage(format!("{}: {e}", options.input.display())))?;
            for note in &solid.notes {
                println!("{note}");
            }
            if let Some(report) = &solid.report {
                print_quality(report);
            }
            println!("made in {:.2} s", start.elapsed().as_secs_f64());
            Mesh::Solid(LabelledTets { mesh: solid.mesh, labels: Vec::new() })
        }
        other => other,
    };
    write(&options.output, &mesh)?;
    Ok(ExitCode::SUCCESS)
}

/// Counts, angles with a histogram, and distance to the surface.
pub(crate) fn print_quality(report: &Report) {
    println!(
        "{} tetrahedra, {} vertices, {} triangles outside, mean edge {:.4e} m",
        report.tets, report.vertices, report.boundary_triangles, report.mean_edge
    );
    print!("volume {:.6e} m³", report.volume);
    match report.volume_ratio {
        Some(ratio) => println!(", {:+.2} % against the surface", 100.0 * (ratio - 1.0)),
        None => println!(),
    }
    if report.size > 0.0 {
        let far = report.hausdorff();
        let at = far.at;
        println!(
            "farthest from the surface {:.3} element sizes, at ({:.4}, {:.4}, {:.4})",
            far.sizes, at.x, at.y, at.z
        );
    }
    println!("dihedral angles {:.1}° to {:.1}°", report.min_dihedral, report.max_dihedral);
    let most = report.histogram.iter().copied().max().unwrap_or(0).max(1);
    for (bin, &count) in report.histogram.iter().enumerate() {
        let bar = "#".repeat((count * 40).div_ceil(most));
        println!("{:>4}-{:<3}° {count:>9} {bar}", bin * 10, bin * 10 + 10);
    }
}
