//! Version 4.1: nodes and elements in blocks, one entity each; physical groups hang on the entities.

use super::Reader;
use crate::mesh::error::MeshError;
use crate::mesh::scalar::Scalar;

/// `size_t` of the format.
const SIZE: Scalar = Scalar::U64;

impl Reader<'_> {
    /// After the section's name: the rest of its line, then numbers in the file's encoding.
    fn open(&mut self) {
        self.at.line();
        self.at.endian = self.encoding;
    }

    /// Physical groups of the volumes.
    pub(super) fn entities_4(&mut self) -> Result<(), MeshError> {
        self.open();
        let mut counts = [0; 4];
        for n in &mut counts {
            *n = self.at.counted(SIZE, [10, 36], "entities")?;
        }
        for (dimension, count) in counts.into_iter().enumerate() {
            for _ in 0..count {
                let tag = self.int("the entities")?;
                for _ in 0..if dimension == 0 { 3 } else { 6 } {
                    self.at.real(Scalar::F64, "the entities")?;
                }
                let groups = self.at.counted(SIZE, [2, 4], "physical groups")?;
                for k in 0..groups {
                    let group = self.int("the physical groups")?;
                    if dimension == 3 && k == 0 {
                        self.groups.insert(tag, group);
                    }
                }
                if dimension > 0 {
                    for _ in 0..self.at.counted(SIZE, [2, 4], "bounding entities")? {
                        self.int("the bounding entities")?;
                    }
                }
            }
        }
        Ok(())
    }

    /// Number of blocks; the totals that follow it say nothing new.
    fn blocks(&mut self, what: &str) -> Result<usize, MeshError> {
        self.open();
        let blocks = self.at.counted(SIZE, [8, 20], what)?;
        for _ in 0..3 {
            self.at.int(SIZE, what)?;
        }
        Ok(blocks)
    }

    pub(super) fn nodes_4(&mut self) -> Result<(), MeshError> {
        for _ in 0..self.blocks("blocks of nodes")? {
            let dimension = self.int("the nodes")?;
            let _entity = self.int("the nodes")?;
            let parametric = self.int("the nodes")?;
            let extra = if parametric == 0 { 0 } else { dimension };
            let count = self.at.counted(SIZE, [8, 32], "nodes")?;
            let numbers = self.at.ints(SIZE, count, "the node numbers")?;
            for number in numbers {
                let [x, y, z] = [(); 3].map(|()| self.at.real(Scalar::F64, "the nodes"));
                self.out.vertex(&self.at, number, [x?, y?, z?])?;
                for _ in 0..extra {
                    self.at.real(Scalar::F64, "the parameters of nodes")?;
                }
            }
        }
        Ok(())
    }

    pub(super) fn elements_4(&mut self) -> Result<(), MeshError> {
        for _ in 0..self.blocks("blocks of elements")? {
            let _dimension = self.int("the elements")?;
            let entity = self.int("the elements")?;
            let kind = self.int("the elements")?;
            let nodes = self.nodes_of(kind)?;
            let count = self.at.counted(SIZE, [2 * (1 + nodes), 8 * (1 + nodes)], "elements")?;
            let tags = [self.groups.get(&entity).copied().unwrap_or(0), entity];
            for _ in 0..count {
                let number = self.at.int(SIZE, "the elements")?;
                self.element(kind, nodes, number, SIZE, tags)?;
            }
        }
        Ok(())
    }
}
