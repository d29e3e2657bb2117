//! Checkpoints, written behind the run's back.

use std::path::PathBuf;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;

use fissure_engine::column::Life;
use fissure_io::checkpoint::{About, CheckpointError, Columns, Snapshot, Store, Written};

/// A thread that writes copies of the state: a step waits for one copy in memory, and for the checkpoint before it if that
/// is not on the disk yet.
pub(super) struct Saver {
    orders: Option<Sender<(Snapshot, About)>>,
    done: Receiver<(Snapshot, Result<Written, CheckpointError>)>,
    thread: Option<JoinHandle<()>>,
    /// The copy's memory, while nothing is being written.
    copy: Option<Snapshot>,
}

impl Saver {
    /// Takes over the store; its frozen columns must be written.
    pub fn new(mut store: Store) -> std::io::Result<Self> {
        let (orders, inbox) = channel::<(Snapshot, About)>();
        let (outbox, done) = channel();
        let thread = std::thread::Builder::new().name("checkpoints".into()).spawn(move || {
            for (mut copy, about) in inbox {
                let written = store.write_live(&mut copy, &about);
                if outbox.send((copy, written)).is_err() {
                    return; // nobody waits any more
                }
            }
        })?;
        Ok(Self { orders: Some(orders), done, thread: Some(thread), copy: Some(Snapshot::default()) })
    }

    /// Copies the live columns and lets them be written. An error is that of the checkpoint before this one.
    pub fn save(&mut self, source: &mut dyn Columns, about: About) -> Result<(), CheckpointError> {
        let before = self.wait();
        let mut copy = self.copy.take().unwrap_or_default();
        copy.take(source, Life::Live);
        let orders = self.orders.as_ref().expect("taken only when dropped");
        orders.send((copy, about)).expect("the thread ends only when dropped");
        before.map(|_| ())
    }

    /// Waits for the checkpoint that is being written: where it is, or nothing if none was.
    pub fn wait(&mut self) -> Result<Option<PathBuf>, CheckpointError> {
        if self.copy.is_some() {
            return Ok(None);
        }
        let (copy, written) = self.done.recv().expect("the thread ends only when dropped");
        self.copy = Some(copy);
        written.map(|w| Some(w.path))
    }
}

impl Drop for Saver {
    /// Lets what is being written come to its end.
    fn drop(&mut self) {
        self.orders = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join(); // a panic there has been printed
        }
    }
}
