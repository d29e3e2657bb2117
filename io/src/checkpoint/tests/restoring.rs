//! What is saved comes back, bit for bit, as mapped memory; what does not fit is refused.

use super::super::{CheckpointError, Range, summary};
use super::*;
use fissure_engine::column::DType;

#[test]
fn every_type_comes_back_with_the_same_bits() {
    let dir = tempfile::tempdir().unwrap();
    for n in [0, 1, 17, 1000] {
        let mut original = thing(n);
        let (frozen, live) = pair(dir.path(), &mut original);
        let (frozen, live) = (Opened::open(frozen).unwrap(), Opened::open(live).unwrap());
        let mut restored = Thing::default();
        live.restore(&mut restored, &frozen).unwrap();
        assert_eq!(bits(&mut restored), bits(&mut original));
        assert_eq!(*live.about(), about(7));
        for (section, bytes) in frozen.iter().chain(live.iter()) {
            assert_eq!(bytes.as_ptr() as usize % 64, 0, "{}", section.label());
        }
    }
}

#[test]
fn restored_columns_are_maps_that_outlive_the_files() {
    let dir = tempfile::tempdir().unwrap();
    let mut original = thing(40);
    let (frozen, live) = pair(dir.path(), &mut original);
    let before = (std::fs::read(&frozen).unwrap(), std::fs::read(&live).unwrap());
    let mut restored = Thing::default();
    {
        let (frozen, live) = (Opened::open(&frozen).unwrap(), Opened::open(&live).unwrap());
        live.restore(&mut restored, &frozen).unwrap();
    }
    assert!(restored.rest.is_mapped() && restored.position.is_mapped() && restored.pieces.is_mapped());

    // Live columns are written in place, frozen ones copied first; neither reaches the file.
    restored.position[3] = DVec3::splat(9.0);
    restored.damage.fill(1.0);
    restored.rest[0] = DVec3::ZERO;
    assert!(restored.position.is_mapped() && restored.damage.is_mapped() && !restored.rest.is_mapped());
    assert!(before == (std::fs::read(&frozen).unwrap(), std::fs::read(&live).unwrap()));
    assert_eq!(&restored.position[4..], &original.position[4..]);

    // A restored thing can be saved over the very file that it maps.
    write(&live, Life::Live, 1, &about(8), &mut restored).unwrap();
    std::fs::remove_file(&frozen).unwrap();
    assert_eq!(open_all(&live).unwrap().column::<DVec3>("vase", "position").unwrap()[3], DVec3::splat(9.0));
    assert_eq!(&restored.neighbours[..], &original.neighbours[..]);
}

#[test]
fn a_column_is_read_by_name_and_type() {
    let dir = tempfile::tempdir().unwrap();
    let mut original = thing(9);
    let (_, live) = pair(dir.path(), &mut original);
    let live = Opened::open(live).unwrap();
    assert_eq!(live.column::<DVec3>("vase", "position").unwrap(), &original.position[..]);
    assert_eq!(live.column::<u32>("vase/mesh", "pieces").unwrap(), &[] as &[u32]);
    let e = live.column::<f64>("vase", "position").unwrap_err().to_string();
    assert!(e.contains("`vase/position` as f64 × 3 [m] where f64 [m] is needed"), "{e}");
    let e = live.column::<f64>("vase", "pressure").unwrap_err().to_string();
    assert!(e.contains("no column `vase/pressure`"), "{e}");
}

#[test]
fn a_late_column_may_be_missing_and_no_other() {
    let dir = tempfile::tempdir().unwrap();
    let without = |_: &str, c: Column| (c.name != "energy").then_some(c);
    let mut old = Changed { inner: thing(6), change: &without };
    let (frozen, live) = pair(dir.path(), &mut old);
    let (frozen, live) = (Opened::open(frozen).unwrap(), Opened::open(live).unwrap());
    let late = |_: &str, c: Column| Some(if c.name == "energy" { c.late() } else { c });
    let mut target = Changed { inner: Thing::default(), change: &late };
    live.restore(&mut target, &frozen).unwrap();
    assert_eq!((&target.inner.energy[..], &target.inner.seed[..]), (&[][..], &[u64::MAX - 1][..]));
    assert_eq!(target.inner.position[..], thing(6).position[..]);

    // with the column, a late one is restored like any other
    let (frozen, live) = pair(dir.path(), &mut thing(6));
    Opened::open(live).unwrap().restore(&mut target, &Opened::open(frozen).unwrap()).unwrap();
    assert_eq!(target.inner.energy[..], [-1.5, 2.5]);
}

/// Restores into a thing whose declarations are changed, and gives the error with what the target then holds.
fn refused(change: &dyn Fn(&str, Column) -> Option<Column>) -> String {
    let dir = tempfile::tempdir().unwrap();
    let (frozen, live) = pair(dir.path(), &mut thing(6));
    let (frozen, live) = (Opened::open(frozen).unwrap(), Opened::open(live).unwrap());
    let mut target = Changed { inner: thing(2), change };
    let e = live.restore(&mut target, &frozen).unwrap_err();
    assert_eq!(bits(&mut target.inner), bits(&mut thing(2)), "changed in spite of: {e}");
    e.to_string()
}

#[test]
fn what_does_not_match_is_refused_before_anything_changes() {
    let renamed = |from: &'static str, to: &'static str| {
        move |_: &str, c: Column| Some(Column { name: if c.name == from { to } else { c.name }, ..c })
    };
    let e = refused(&renamed("damage", "phase"));
    assert!(e.contains("live.fis` has no column `vase/phase`; resume with"), "{e}");
    let e = refused(&renamed("rest_position", "start"));
    assert!(e.contains("frozen.fis` has no column `vase/start`"), "{e}");
    let e = refused(&|_, c| (c.name != "damage").then_some(c));
    assert!(e.contains("live.fis` has a column `vase/damage` that this run does not know"), "{e}");
    let e = refused(&|_, c| (c.name != "tets").then_some(c));
    assert!(e.contains("frozen.fis` has a column `vase/mesh/tets` that"), "{e}");
    let e = refused(&|_, c| Some(Column { unit: if c.name == "energy" { "kJ" } else { c.unit }, ..c }));
    assert!(e.contains("`energy` as f64 [J] where f64 [kJ] is needed"), "{e}");
    let e = refused(&renamed("pieces", "normal"));
    assert!(e.contains("two columns are called `vase/mesh/normal`"), "{e}");
    let e = refused(&|_, c| Some(Column { life: if c.name == "seed" { Life::Frozen } else { c.life }, ..c }));
    assert!(e.contains("frozen.fis` has no column `seed`"), "{e}");

    /// `energy` with another number type.
    struct Other(Buffer<f32>);
    impl Columns for Other {
        fn visit(&mut self, v: &mut Visitor<'_>) {
            v("", &Column::live("energy", "J", Of::Thing), &mut self.0);
        }
    }
    let dir = tempfile::tempdir().unwrap();
    let (frozen, live) = pair(dir.path(), &mut thing(6));
    let (frozen, live) = (Opened::open(frozen).unwrap(), Opened::open(live).unwrap());
    let e = live.restore(&mut Other(Buffer::default()), &frozen).unwrap_err().to_string();
    assert!(e.contains("`energy` as f64 [J] where f32 [J] is needed"), "{e}");
}

#[test]
fn files_of_different_runs_or_kinds_are_refused() {
    let (here, there) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let (frozen, live) = pair(here.path(), &mut thing(6));
    let (other, _) = pair(there.path(), &mut thing(7));
    let open = |path| Opened::open(path).unwrap();
    let mut target = Thing::default();
    let e = open(&live).restore(&mut target, &open(&other)).unwrap_err();
    assert!(matches!(e, CheckpointError::OtherRun { .. }), "{e}");
    assert!(e.to_string().contains("use the frozen.fis of its own run"), "{e}");
    let e = open(&live).restore(&mut target, &open(&live)).unwrap_err().to_string();
    assert!(e.contains("holds live columns where frozen ones are needed; name the run's frozen.fis"), "{e}");
    let e = open(&frozen).restore(&mut target, &open(&frozen)).unwrap_err().to_string();
    assert!(e.contains("holds frozen columns where live ones are needed"), "{e}");
    assert_eq!(bits(&mut target), bits(&mut Thing::default()));
}

#[test]
fn two_columns_of_one_name_are_not_written() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("live.fis");
    let mut twice = Changed {
        inner: thing(2),
        change: &|_, c| Some(Column { name: if c.name == "pieces" { "normal" } else { c.name }, ..c }),
    };
    let e = write(&path, Life::Live, 0, &about(1), &mut twice).unwrap_err().to_string();
    assert!(e.contains("two columns are called `vase/mesh/normal`"), "{e}");
    assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 0, "something was left behind");
}

#[test]
fn a_summary_has_ranges_nans_and_the_damaged_column() {
    let dir = tempfile::tempdir().unwrap();
    let (_, live) = pair(dir.path(), &mut thing(200_000)); // columns longer than one piece of reading
    let good = summary(&live).unwrap();
    assert!(good.intact());
    let column = |name: &str| good.columns.iter().find(|c| c.section.name == name).unwrap();
    assert_eq!((column("damage").range, column("damage").nans), (Range::Float(0.0, f64::from(199_999f32 / 2e5)), 1));
    assert_eq!(column("energy").range, Range::Float(-1.5, 2.5));
    assert_eq!(column("a_rather_long_name_of_frames").range, Range::Float(-2.0, f64::INFINITY));
    assert_eq!(column("broken").range, Range::Whole(0, 255));
    assert_eq!(column("seed").range, Range::Whole(u64::MAX - 1, u64::MAX - 1));
    assert_eq!((column("pieces").range, column("pieces").section.count), (Range::None, 0));
    assert_eq!((column("position").section.dtype, column("position").section.unit.as_str()), (DType::F64, "m"));
    assert_eq!((good.about.step, good.about.time), (7, 3.5e-3));

    let at = column("damage").section.offset + 2_000;
    let mut bytes = std::fs::read(&live).unwrap();
    bytes[at] ^= 4;
    std::fs::write(&live, bytes).unwrap();
    let bad = summary(&live).unwrap();
    let damaged: Vec<&str> = bad.columns.iter().filter(|c| !c.intact).map(|c| c.section.name.as_str()).collect();
    assert_eq!(damaged, ["damage"]);
    assert!(bad.to_string().lines().any(|l| l.contains("vase/damage") && l.contains("DAMAGED")), "{bad}");
}
