//! The command line.

use std::path::PathBuf;

use clap::{Args as Group, Parser, Subcommand};

/// Simulate solids which bend, yield, tear and shatter.
#[derive(Parser)]
#[command(name = "fissure", version, about, max_term_width = 100)]
pub(crate) struct Args {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Subcommand)]
pub(crate) enum Command {
    /// Run a scene: frames, checkpoints, a log and a picture of the last frame
    #[command(after_help = "Examples:\n  fissure run scenes/vase.toml\n  \
        fissure run scenes/bunny.toml --set body.bunny.mesh=my/bunny.ply --set body.bunny.tets=300000 --out runs/fine")]
    Run {
        /// The scene file (TOML)
        scene: PathBuf,
        /// The run folder to make [default: runs/ and the scene's name]
        #[arg(long)]
        out: Option<PathBuf>,
        #[command(flatten)]
        run: RunArgs,
    },
    /// Go on with an interrupted run, to the same bits as if it had not been interrupted
    #[command(after_help = "Examples:\n  fissure resume runs/vase\n  \
        fissure resume runs/vase --until 0.05 --threads 1")]
    Resume {
        /// The run folder
        dir: PathBuf,
        /// Go on although scene.toml was changed since the checkpoint; checkpoints record the change
        #[arg(long)]
        force: bool,
        #[command(flatten)]
        run: RunArgs,
    },
    /// Say what is in a scene, mesh, checkpoint, frame or run folder
    #[command(after_help = "Examples:\n  fissure info runs/vase\n  fissure info runs/vase/frozen.fis\n  \
        fissure info runs/vase/frames/frame_0012.ply\n  fissure info bunny.ply --json\n  \
        fissure info runs/vase/checkpoint_00001449.fis --scene > vase_again.toml")]
    Info(InfoArgs),
    /// Read every byte of a checkpoint, or of all files of a run, and check it
    #[command(after_help = "Examples:\n  fissure verify runs/vase\n  \
        fissure verify runs/vase/checkpoint_00001449.fis && cp -r runs/vase /archive")]
    Verify {
        /// The checkpoint or run folder
        path: PathBuf,
    },
    /// Write a run, its fragments, or the columns of a checkpoint for other programs
    #[command(
        after_help = "Examples:\n  fissure export runs/vase --to usd\n  fissure export runs/vase --fragments\n  \
        fissure export runs/vase/checkpoint_00001911.fis --to npy --out columns\n\n\
        Of a run:\n  usd: runs/vase/usd/stage.usda for Blender, Houdini, usdview\n  \
        vtu: runs/vase/vtu/surface.pvd and particles.pvd for ParaView, pyvista, meshio\n  \
        glb: runs/vase/run.glb for game engines, a node per fragment with its rigid motion\n  \
        ply, obj, pov: a file per frame, with colours, groups per fragment, or as scenes for POV-Ray\n  \
        html: runs/vase/run.html, the page of `fissure view` as one file to send; --every 4 --no-particles for a smaller one\n  \
        --fragments: fragments.csv with mass, inertia, place, velocity and spin of each fragment at each frame\n\
        With output.export = [\"usd\", ...] in the scene, a run writes them as it goes on.\n\n\
        Of a checkpoint:\n  csv: a row per particle. npy: a folder with a NumPy file per column. vtu: particles.\n  \
        What never changes is taken from frozen.fis beside it."
    )]
    Export(ExportArgs),
    /// Make tetrahedra from a surface, or convert a mesh; reports the quality
    #[command(after_help = "Examples:\n  fissure mesh bunny.ply bunny.msh --tets 100000\n  \
        fissure mesh leaf.obj leaf.vtu --shell 0.02\n  fissure mesh solid.node solid.vtu")]
    Mesh(MeshArgs),
    /// List the materials and fracture criteria, or explain one
    #[command(after_help = "Examples:\n  fissure materials\n  fissure materials plastic\n  \
        fissure materials tension_shear")]
    Materials {
        /// The material or criterion to explain
        name: Option<String>,
    },
    /// List the keys of scene files, or those with a word in them
    #[command(after_help = "Examples:\n  fissure keys anchor\n  fissure keys frames_per_second")]
    Keys {
        /// A part of the key, e.g. anchor
        part: Option<String>,
    },
    /// Draw frames of a run: PNG, or a film as GIF or animated PNG
    #[command(after_help = "Examples:\n  fissure render runs/vase --frame 12 --color damage\n  \
        fissure render runs/vase --all\n  fissure render runs/vase --film vase.gif --size 640x360 --every 2")]
    Render(RenderArgs),
    /// Show a run, or two side by side, on a page in the browser, also while it runs
    #[command(after_help = "Examples:\n  fissure view runs/vase --open\n  fissure view runs/before runs/after\n\n\
        The page is served to this machine only, at the address that is printed. `fissure export RUN --to html` makes a \
        file of it.")]
    View(ViewArgs),
    /// Draw what a run measured over time: energies, broken bonds, fragments, where the time went
    #[command(after_help = "Examples:\n  fissure plot runs/vase\n  fissure plot runs/vase --out vase.svg")]
    Plot(PlotArgs),
    /// Say before a run what it will be: particles, bonds, memory, time step, steps and about how long
    #[command(after_help = "Example:\n  fissure check scenes/vase.toml --set body.vase.tets=300000")]
    Check(CheckArgs),
    /// Print the JSON Schema of scene files, with which editors complete and check them
    #[command(after_help = "Example:\n  fissure schema > fissure.json, and as the first line of a scene: \
        #:schema ./fissure.json")]
    Schema,
    /// Print the completions for a shell
    #[command(after_help = "Example:\n  fissure completions bash > ~/.local/share/bash-completion/completions/fissure")]
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
    /// Write the manual: a page for the program and one for each command
    #[command(after_help = "Example:\n  fissure man ~/.local/share/man/man1, then: man fissure-run")]
    Man {
        /// The folder for the pages
        out: PathBuf,
    },
    /// Time the step on this machine, and say how near it is to what the memory allows
    #[command(after_help = "Examples:\n  fissure bench\n  fissure bench --edge 32 --json")]
    Bench(BenchArgs),
    /// Say what differs between two runs, checkpoints or scenes; exit code 0: the same, 1: differs, 2: trouble
    #[command(after_help = "Examples:\n  fissure diff runs/before runs/after\n  \
        fissure diff a/checkpoint_00000100.fis b/checkpoint_00000100.fis --columns position --tolerance 1e-9\n  \
        fissure diff runs/before runs/after --png where.png\n  fissure diff scenes/old.toml scenes/new.toml --json")]
    Diff(DiffArgs),
}

#[derive(Group, Clone, Default)]
pub(crate) struct RunArgs {
    /// Stop at this simulated time [s], with a checkpoint
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    pub until: Option<f64>,
    /// Number of threads; the result has the same bits for any [default: all]
    #[arg(long, allow_negative_numbers = true)]
    pub threads: Option<usize>,
    /// Change a key of the scene, e.g. body.vase.tets=300000
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// Draw a small picture of every frame, into the folder `preview`
    #[arg(long)]
    pub preview: bool,
    /// Print nothing but errors
    #[arg(long)]
    pub quiet: bool,
    /// Print one JSON object per event
    #[arg(long, conflicts_with = "quiet")]
    pub json: bool,
}

#[derive(Group)]
pub(crate) struct MeshArgs {
    /// The mesh to read: obj, ply, stl; node/ele, msh, vtu, vtk
    pub input: PathBuf,
    /// The mesh to write: node/ele, msh, vtu for tetrahedra; obj, ply, stl for surfaces
    pub output: PathBuf,
    /// Mean edge length of the tetrahedra [m]
    #[arg(long, value_name = "METRES", allow_negative_numbers = true)]
    pub size: Option<f64>,
    /// Number of tetrahedra, about [default: 20000]
    #[arg(long, conflicts_with = "size", allow_negative_numbers = true)]
    pub tets: Option<u64>,
    /// Turn the surface, open or closed, into a wall of this thickness [m]
    #[arg(long, value_name = "METRES", allow_negative_numbers = true)]
    pub shell: Option<f64>,
    /// Which of many equally good irregular meshes
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
}

#[derive(Group)]
pub(crate) struct RenderArgs {
    /// The run folder
    pub dir: PathBuf,
    /// The frame [default: the last]
    #[arg(long, conflicts_with_all = ["all", "film"])]
    pub frame: Option<u32>,
    /// Every frame, into the folder `pictures` of the run or that of --out
    #[arg(long)]
    pub all: bool,
    /// One moving picture of all frames: a .gif, or a .png that moves (APNG)
    #[arg(long, value_name = "FILE", conflicts_with_all = ["all", "out"])]
    pub film: Option<PathBuf>,
    /// The same as --film RUN/film.gif
    #[arg(long, conflicts_with_all = ["all", "out", "film", "frame"])]
    pub gif: bool,
    /// With --all and --film: only every so manyth frame
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    pub every: u32,
    /// With --film: pictures per second [default: those of the run, at most 50]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub fps: Option<f64>,
    /// The picture to write [default: frame_NNNN.png in the run folder]
    #[arg(long)]
    pub out: Option<PathBuf>,
    /// What gives the colour
    #[arg(long, value_parser = ["material", "damage", "stretch", "speed", "piece"])]
    pub color: Option<String>,
    /// Width and height in pixels, e.g. 640x360 [default: those of the scene]
    #[arg(long, value_name = "WxH")]
    pub size: Option<String>,
}

#[derive(Group)]
pub(crate) struct PlotArgs {
    /// The run folder
    pub dir: PathBuf,
    /// The file to write, by its ending: .png, .svg or .csv [default: plot.png in the run folder]
    #[arg(long)]
    pub out: Option<PathBuf>,
}

#[derive(Group)]
pub(crate) struct CheckArgs {
    /// The scene file (TOML)
    pub scene: PathBuf,
    /// Change a key of the scene, e.g. body.vase.tets=300000
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// Number of threads [default: all]
    #[arg(long, allow_negative_numbers = true)]
    pub threads: Option<usize>,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

#[derive(Group)]
pub(crate) struct ViewArgs {
    /// The run folder
    #[arg(value_name = "RUN")]
    pub dir: PathBuf,
    /// Another run, to compare with
    #[arg(value_name = "RUN2")]
    pub other: Option<PathBuf>,
    /// The port on 127.0.0.1 [default: any that is free]
    #[arg(long, default_value_t = 0, hide_default_value = true)]
    pub port: u16,
    /// Open the page in the browser
    #[arg(long)]
    pub open: bool,
}

#[derive(Group)]
pub(crate) struct ExportArgs {
    /// The run folder, or a checkpoint (.fis)
    pub path: PathBuf,
    /// The format [default: csv for a checkpoint]
    #[arg(long, value_parser = ["usd", "vtu", "ply", "obj", "glb", "pov", "html", "csv", "npy"])]
    pub to: Option<String>,
    /// The file or folder to write [default: in the run folder, or beside the checkpoint]
    #[arg(long)]
    pub out: Option<PathBuf>,
    /// The fragments of a run as a table (CSV)
    #[arg(long, conflicts_with = "to")]
    pub fragments: bool,
    /// Of html: only every so manieth frame, and the last
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    pub every: u32,
    /// Of html: without the particles, which are about half of it
    #[arg(long)]
    pub no_particles: bool,
}

#[derive(Group)]
pub(crate) struct BenchArgs {
    /// Particles along the edge of the block; smaller ones than the default may lie in caches
    #[arg(long, default_value_t = 67, value_parser = clap::value_parser!(i32).range(8..=120))]
    pub edge: i32,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

#[derive(Group)]
pub(crate) struct InfoArgs {
    /// The file or folder
    pub file: PathBuf,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
    /// Of a checkpoint: print the scene that made it
    #[arg(long, conflicts_with = "json")]
    pub scene: bool,
}

#[derive(Group)]
pub(crate) struct DiffArgs {
    /// A run folder, a checkpoint (.fis) or a scene (.toml)
    pub a: PathBuf,
    /// Another of the same kind
    pub b: PathBuf,
    /// Numbers no farther apart than this count as the same, in the unit of their column
    #[arg(long, value_name = "NUMBER", default_value_t = 0.0, allow_negative_numbers = true)]
    pub tolerance: f64,
    /// Only columns with this in their name, e.g. position
    #[arg(long, value_name = "PART", default_value = "", hide_default_value = true)]
    pub columns: String,
    /// Draw where the first differing column differs: pale where not, deep red where most
    #[arg(long, value_name = "FILE")]
    pub png: Option<PathBuf>,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}
