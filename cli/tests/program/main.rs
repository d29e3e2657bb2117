//! The program as a whole, from outside: command lines in, files, words and exit codes out.
//!
//! | module | promise |
//! |---|---|
//! | `running` | what a run leaves, what it says, the same bits on any number of threads |
//! | `resuming` | stopped, interrupted or killed, then resumed: the same bytes as never stopped |
//! | `colliders` | rigid things: every kind runs and resumes; what is wrong with one |
//! | `commands` | `info`, `mesh`, `materials`, `render` |
//! | `diffing` | `diff`: what it says and its exit codes |
//! | `failing` | the disk that fails, and programs that are killed: the last checkpoint stays |
//! | `parameters` | bad values of laws and criteria: file, line, key, unit and range |
//! | `refusing` | bad input: one sentence, exit code 2, nothing half-written |
//! | `figures` | figures 9 to 13 of Chen et al. against references: table, plot, and going on with them |
//! | `lattices` | bodies made of cells: run, resumed, compared, drawn |
//! | `viewing` | the page of `view`: what it serves, and to whom |
//! | `seeing` | `plot`, films, previews; `check`, `schema`, `completions`, `man` |
//! | `meshes` | meshes that other people made (`FISSURE_MESHES`) |

mod colliders;
mod commands;
mod diffing;
mod exporting;
mod failing;
mod figures;
mod lattices;
mod meshes;
mod parameters;
mod refusing;
mod resuming;
mod running;
mod seeing;
mod viewing;
mod workshop;
