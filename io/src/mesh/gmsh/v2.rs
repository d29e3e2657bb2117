//! Version 2: the counts are text in binary files too; elements carry their tags.

use super::Reader;
use crate::mesh::error::MeshError;
use crate::mesh::scalar::Scalar;

impl Reader<'_> {
    /// The text count at the head of a section of things of at least so many bytes (text, binary).
    fn head(&mut self, each: [usize; 2], what: &str) -> Result<usize, MeshError> {
        let n = self.at.parse(what)?;
        let n = self.at.count(n, if self.encoding.is_none() { each[0] } else { each[1] }, what)?;
        self.at.line();
        self.at.endian = self.encoding;
        Ok(n)
    }

    /// Nodes; `parametric` ones carry the dimension and tag of their entity and its 1 or 2 surface coordinates.
    pub(super) fn nodes_2(&mut self, parametric: bool) -> Result<(), MeshError> {
        for _ in 0..self.head([8, 28], "nodes")? {
            let number = self.int("the nodes")?;
            let [x, y, z] = [(); 3].map(|()| self.at.real(Scalar::F64, "the nodes"));
            self.out.vertex(&self.at, number, [x?, y?, z?])?;
            if parametric {
                let dimension = self.int("the parameters of nodes")?;
                let _entity = self.int("the parameters of nodes")?;
                for _ in 0..if matches!(dimension, 1 | 2) { dimension } else { 0 } {
                    self.at.real(Scalar::F64, "the parameters of nodes")?;
                }
            }
        }
        Ok(())
    }

    pub(super) fn elements_2(&mut self) -> Result<(), MeshError> {
        let count = self.head([6, 8], "elements")?;
        let mut done = 0;
        while done < count {
            // In text each element has its own type and tags, in binary a run of them shares the head.
            let (number, kind, run, tags);
            if self.encoding.is_none() {
                number = Some(self.int("the elements")?);
                (kind, run, tags) = (self.int("the elements")?, 1, self.int("the tags")?);
            } else {
                number = None;
                (kind, run, tags) = (self.int("the elements")?, self.int("the elements")?, self.int("the tags")?);
            }
            let nodes = self.nodes_of(kind)?;
            if run < 1 || run > (count - done) as i64 {
                return Err(self.at.unexpected("a run of as many elements as are left", run.to_string().as_bytes()));
            }
            for _ in 0..run {
                let number = match number {
                    Some(number) => number,
                    None => self.int("the elements")?,
                };
                // Physical group, entity, then partitions.
                let mut known = [0; 2];
                for k in 0..tags {
                    let tag = self.int("the tags")?;
                    if k < 2 {
                        known[k as usize] = tag;
                    }
                }
                self.element(kind, nodes, number, Scalar::I32, known)?;
            }
            done += run as usize;
        }
        Ok(())
    }
}
