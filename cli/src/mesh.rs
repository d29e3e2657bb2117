//! `fissure mesh`: tetrahedra from a surface with their quality, or one format to another.

use std::process::ExitCode;
use std::time::Instant;

use fissure_io::mesh::{LabelledTets, Mesh, read, write};
use fissure_io::scene::Resolution;
use fissure_io::simulation::fill;
use fissure_meshing::quality::Report;

use crate::Error;
use crate::args::MeshArgs;
use crate::say::say;

pub(crate) fn command(options: &MeshArgs) -> Result<ExitCode, Error> {
    let surface_out = options.output.extension().is_some_and(|e| {
        let e = e.to_string_lossy().to_lowercase();
        ["obj", "ply", "stl"].contains(&e.as_str())
    });
    let mesh = match read(&options.input)? {
        Mesh::Surface(surface) if !surface_out => {
            in_range(options)?;
            let resolution = match options.size {
                Some(size) => Resolution::Size(size),
                None => Resolution::Tets(options.tets.unwrap_or(20_000)),
            };
            let start = Instant::now();
            let solid = fill(surface, resolution, options.shell, options.seed)
                .map_err(|e| Error::Usage(format!("{}: {e}", options.input.display())))?;
            for note in &solid.notes {
                say!("{note}");
            }
            if let Some(report) = &solid.report {
                quality(report).iter().for_each(|line| say!("{line}"));
            }
            say!("made in {:.2} s", start.elapsed().as_secs_f64());
            Mesh::Solid(LabelledTets { mesh: solid.mesh, labels: Vec::new() })
        }
        other => {
            nothing_to_fill(options, matches!(other, Mesh::Solid(_)))?;
            other
        }
    };
    write(&options.output, &mesh)?;
    Ok(ExitCode::SUCCESS)
}

fn in_range(options: &MeshArgs) -> Result<(), Error> {
    for (name, value) in [("size", options.size), ("shell", options.shell)] {
        if let Some(value) = value.filter(|v| !(*v > 0.0 && v.is_finite())) {
            return Err(Error::Usage(format!("--{name} {value} must be a finite number above 0 [m]")));
        }
    }
    if options.tets == Some(0) {
        return Err(Error::Usage("--tets must be 1 or more".into()));
    }
    Ok(())
}

/// Refuses what only has a meaning where tetrahedra are made, rather than passing over it.
fn nothing_to_fill(options: &MeshArgs, solid: bool) -> Result<(), Error> {
    let given =
        [("size", options.size.is_some()), ("tets", options.tets.is_some()), ("shell", options.shell.is_some())];
    let Some((name, _)) = given.iter().find(|g| g.1) else { return Ok(()) };
    let (file, cure) = if solid {
        (&options.input, "holds tetrahedra already; leave it out, or give a surface")
    } else {
        (&options.output, "is to hold a surface; leave it out, or write .vtu, .msh or .node")
    };
    Err(Error::Usage(format!("--{name} is for filling a surface, but {} {cure}", file.display())))
}

/// Counts, angles with a histogram, and distance to the surface.
pub(crate) fn quality(report: &Report) -> Vec<String> {
    let against = |ratio: f64| format!(", {:+.2} % against the surface", 100.0 * (ratio - 1.0));
    let mut words = vec![
        format!(
            "{} tetrahedra, {} vertices, {} triangles outside, mean edge {:.4e} m",
            report.tets, report.vertices, report.boundary_triangles, report.mean_edge
        ),
        format!("volume {:.6e} m³{}", report.volume, report.volume_ratio.map(against).unwrap_or_default()),
    ];
    if report.size > 0.0 {
        let (sizes, at) = (report.hausdorff().sizes, report.hausdorff().at);
        words.push(format!(
            "farthest from the surface {sizes:.3} element sizes, at ({:.4}, {:.4}, {:.4})",
            at.x, at.y, at.z
        ));
    }
    words.push(format!("dihedral angles {:.1}° to {:.1}°", report.min_dihedral, report.max_dihedral));
    let most = report.histogram.iter().copied().max().unwrap_or(0).max(1);
    words.extend(report.histogram.iter().enumerate().map(|(bin, &count)| {
        let bar = "#".repeat((count * 40).div_ceil(most));
        format!("{:>4}-{:<3}° {count:>9} {bar}", bin * 10, bin * 10 + 10)
    }));
    words
}
