//! What the targets do with arbitrary bytes. Whatever they are: a value or a sentence, no panic, no hang, no huge allocation.

pub mod restore;

use std::cell::RefCell;
use std::fs;
use std::path::Path;

use fissure_io::checkpoint::{Opened, summary};
use fissure_io::scene::Scene;
use fissure_io::{frames, mesh};
use tempfile::TempDir;

/// Calls `read` with a file called `name` that holds `data`, in a folder of this thread.
fn in_a_file(name: &str, data: &[u8], read: impl FnOnce(&Path)) {
    thread_local!(static FOLDER: RefCell<TempDir> = RefCell::new(TempDir::new().expect("a folder")));
    FOLDER.with_borrow(|folder| {
        let path = folder.path().join(name);
        fs::write(&path, data).expect("room for a file");
        read(&path);
    });
}

/// A message is one sentence that can be shown.
fn check_message(error: &dyn std::error::Error) {
    let message = error.to_string();
    assert!(!message.is_empty() && !message.contains('\n') && message.len() < 10_000, "{message:?}");
}

/// A surface or solid mesh of the format with this extension. What is read can be used: no vertex that is not there, no
/// coordinate that is none.
pub fn mesh(extension: &str, data: &[u8]) {
    in_a_file(&format!("mesh.{extension}"), data, |path| check_mesh(mesh::read(path)));
}

/// A pair of TetGen files, which a zero byte separates.
pub fn tetgen(data: &[u8]) {
    let cut = data.iter().position(|&b| b == 0).unwrap_or(data.len());
    let (node, ele) = (&data[..cut], data.get(cut + 1..).unwrap_or(&[]));
    in_a_file("mesh.ele", ele, |_| in_a_file("mesh.node", node, |path| check_mesh(mesh::read(path))));
}

fn check_mesh(read: Result<mesh::Mesh, mesh::MeshError>) {
    match read {
        Ok(mesh::Mesh::Surface(m)) => {
            assert!(m.vertices.iter().all(|v| v.is_finite()));
            assert!(m.triangles.iter().flatten().all(|&v| (v as usize) < m.vertices.len()));
        }
        Ok(mesh::Mesh::Solid(m)) => {
            assert!(m.mesh.vertices.iter().all(|v| v.is_finite()));
            assert!(m.mesh.tets.iter().flatten().all(|&v| (v as usize) < m.mesh.vertices.len()));
            assert!(m.labels.is_empty() || m.labels.len() == m.mesh.tets.len());
        }
        Err(error) => check_message(&error),
    }
}

/// A scene: read, checked against all materials, and read again from the text that it keeps.
pub fn scene(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    match Scene::parse(text, Path::new("scene.toml"), &[]) {
        Ok(scene) => {
            if let Err(error) = scene.check(&fissure_materials::registry()) {
                assert!(!error.to_string().is_empty());
            }
            let again = Scene::parse(scene.text(), Path::new("scene.toml"), &[]).expect("read before");
            assert_eq!(scene.fingerprint(), again.fingerprint());
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

/// A frame as the program writes it.
pub fn frame(data: &[u8]) {
    match frames::from_bytes(data, Path::new("frame.ply")) {
        Ok(frame) => {
            let _ = frame.check();
        }
        Err(error) => check_message(&error),
    }
}

/// A checkpoint: opened, verified, summed up, every byte of every column read.
pub fn checkpoint(data: &[u8]) {
    in_a_file("checkpoint.fis", data, |path| {
        let opened = match Opened::open(path) {
            Ok(opened) => opened,
            Err(error) => return check_message(&error),
        };
        let ones = opened.iter().flat_map(|(_, bytes)| bytes).filter(|&&b| b == 1).count();
        assert!(ones <= data.len(), "columns that overlap");
        if let Err(error) = opened.verify() {
            check_message(&error);
        }
        summary(path).expect("opened before");
    });
}
