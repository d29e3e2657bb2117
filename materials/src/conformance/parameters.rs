//! What is asked of parameters: that they are declared in full, that what is excluded is refused with a sentence that
//! helps, and that what is admitted works.

use std::panic::{AssertUnwindSafe, catch_unwind};

use fissure_engine::{Kind, Parameter, Range, Value, World};
use glam::{DMat3, DVec3};

use super::body::{Given, Subject, exact_forces, largest, put, strained};
use super::case::said;
use super::report::{Finding, Trouble, fail};

/// The law and every criterion that is registered with it.
pub(super) fn refused_or_working(subject: &Subject<'_>) -> Finding {
    let entry = subject.registry.entry(subject.law)?;
    if entry.summary.trim().is_empty() {
        return fail("it has no line of summary");
    }
    let mut tried = 0;
    let law =
        |given: &Given| subject.registry.make((subject.law, given.clone()), calm(subject), &Subject::surroundings());
    tried += table(entry.parameters, &subject.given, &|given| law(given).map(drop).map_err(|e| e.message))?;
    for (name, given) in &subject.breaking {
        let (Some(criterion), Ok(given)) = (entry.criteria.iter().find(|c| c.name == name), given) else {
            return fail(format!("`{name}`: {}", given.as_ref().err().cloned().unwrap_or_default()));
        };
        let make = |values: &Given| {
            let at = Subject::surroundings();
            subject.registry.make((subject.law, subject.given.clone()), (name, values.clone()), &at)
        };
        tried += table(criterion.parameters, given, &|values| make(values).map(drop).map_err(|e| e.message))?;
    }
    tried += entry.parameters.iter().try_fold(0, |n, p| Ok::<_, Trouble>(n + admitted(subject, p)?))?;
    Ok(format!("{tried} values refused in full sentences or working"))
}

fn calm<'a>(subject: &'a Subject<'_>) -> (&'a str, Given) {
    (&subject.calm.0, subject.calm.1.clone())
}

/// Declarations, and what lies outside them.
fn table(
    parameters: &[Parameter],
    good: &Given,
    make: &dyn Fn(&Given) -> Result<(), String>,
) -> Result<usize, Trouble> {
    let make = |given: &Given| -> Result<Result<(), String>, Trouble> {
        catch_unwind(AssertUnwindSafe(|| make(given))).or_else(|panic| fail(format!("{} of {given:?}", said(&*panic))))
    };
    let mut tried = 1;
    let mut more = good.clone();
    more.push(("no_such_key".into(), Value::Number(1.0)));
    match make(&more)? {
        Err(why) if why.contains("no_such_key") => {}
        other => return fail(format!("the unknown key `no_such_key` is answered with {other:?}")),
    }
    for p in parameters {
        declared(p)?;
        for bad in outside(p) {
            let why = make(&with(good, p.name, Some(bad.clone())))?;
            tried += 1;
            // words and matrices are pure, and their messages say nothing of a unit
            let unit = if matches!(p.kind, Kind::Word(_) | Kind::Matrix) { "" } else { p.unit };
            let parts = [format!("`{}`", p.name), unit.into(), wanted(p)];
            match why {
                Err(why) if parts.iter().all(|s| why.contains(s)) => {}
                Err(why) => return fail(format!("`{}` = {bad} is refused without name, unit or range: {why}", p.name)),
                Ok(()) => return fail(format!("`{}` = {bad} is taken, but it must be {}", p.name, wanted(p))),
            }
        }
        if let Kind::Number(_) = p.kind {
            tried += 1;
            match make(&with(good, p.name, None))? {
                Err(why) if why.contains(p.name) && why.contains(p.unit) => {}
                other => return fail(format!("without `{}` it says {other:?}", p.name)),
            }
        }
    }
    Ok(tried)
}

/// `good` with another value of `key`, or without it.
fn with(good: &Given, key: &str, value: Option<Value>) -> Given {
    let others = good.iter().filter(|(k, _)| k != key).cloned();
    others.chain(value.map(|v| (key.to_string(), v))).collect()
}

/// A declaration is complete: a name that a scene can spell, a unit, a line of help, a default that is admitted.
fn declared(p: &Parameter) -> Result<(), Trouble> {
    let spelt = !p.name.is_empty() && p.name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_');
    if !spelt {
        return fail(format!("the name `{}` is not written in snake_case", p.name));
    }
    if p.unit.is_empty() || p.about.trim().is_empty() {
        return fail(format!("`{}` has no unit (1 for pure numbers) or no line of help", p.name));
    }
    match p.kind {
        Kind::NumberOr(range, default) if !range.contains(default) => {
            fail(format!("the default {default} of `{}` is outside its own range, {range}", p.name))
        }
        Kind::Word([]) => fail(format!("`{}` admits no word", p.name)),
        _ => Ok(()),
    }
}

/// What a message must say of the values that are wanted.
fn wanted(p: &Parameter) -> String {
    match p.kind {
        Kind::Number(r) | Kind::NumberOr(r, _) | Kind::OptionalNumber(r) => r.to_string(),
        Kind::Word(words) => words.join(", "),
        Kind::Matrix => "3 (diagonal) or 9".into(),
        Kind::Vector(_) => "a list of 3 numbers".into(),
    }
}

/// Values that the declaration excludes.
fn outside(p: &Parameter) -> Vec<Value> {
    let numbers = |r: Range| {
        let mut out = vec![f64::NAN];
        let step = |end: f64| end.abs().max(1.0) * 0.1;
        let mut end = |at: f64, belongs: bool, beyond: f64| {
            if !belongs {
                out.push(at);
            }
            if at.is_finite() {
                out.push(at + beyond);
                out.push(if beyond < 0.0 { f64::NEG_INFINITY } else { f64::INFINITY });
            }
        };
        end(r.low.0, r.low.1, -step(r.low.0));
        end(r.high.0, r.high.1, step(r.high.0));
        out.into_iter().map(Value::Number).collect()
    };
    match p.kind {
        Kind::Number(r) | Kind::NumberOr(r, _) | Kind::OptionalNumber(r) => numbers(r),
        Kind::Word(_) => vec![Value::Word("no_such_word".into()), Value::Number(1.0)],
        Kind::Vector(_) => vec![Value::List(vec![1.0; 2]), Value::List(vec![1.0, f64::NAN, 1.0]), Value::Number(1.0)],
        Kind::Matrix => {
            vec![Value::List(vec![1.0; 4]), Value::List(vec![1.0, f64::NAN, 1.0]), Value::Word("identity".into())]
        }
    }
}

/// Values that the declaration admits, out to its ends: the law works with them (forces are numbers that resist, the step
/// is one) or refuses them by name.
fn admitted(subject: &Subject<'_>, p: &Parameter) -> Result<usize, Trouble> {
    let values: Vec<Value> = match p.kind {
        Kind::Number(r) | Kind::NumberOr(r, _) | Kind::OptionalNumber(r) => {
            let usual = super::example::inside(p, &r);
            let towards = |end: (f64, bool), far: f64| {
                let inner = if end.0.is_finite() { end.0 + 1e-3 * (usual - end.0) } else { far };
                [Some(inner), end.1.then_some(end.0)]
            };
            let size = usual.abs().max(1.0) * 100.0;
            let ends = [towards(r.low, -size), towards(r.high, size)];
            ends.into_iter().flatten().flatten().map(Value::Number).collect()
        }
        Kind::Word(words) => words.iter().map(|w| Value::Word(w.to_string())).collect(),
        Kind::Matrix => [vec![0.0; 3], vec![1.0, 2.0, 0.5], vec![0.0; 9]].map(Value::List).into(),
        Kind::Vector(_) => [vec![0.0; 3], vec![1.0, 2.0, 0.5]].map(Value::List).into(),
    };
    for value in &values {
        works(subject, p, value)?;
    }
    Ok(values.len())
}

fn works(subject: &Subject<'_>, p: &Parameter, value: &Value) -> Result<(), Trouble> {
    let given = with(&subject.given, p.name, Some(value.clone()));
    let made = catch_unwind(AssertUnwindSafe(|| {
        subject.registry.make((subject.law, given.clone()), calm(subject), &Subject::surroundings())
    }));
    match made {
        Err(panic) => return fail(format!("{} of `{}` = {value}", said(&*panic), p.name)),
        Ok(Err(e)) if e.message.contains(p.name) => return Ok(()),
        Ok(Err(e)) => return fail(format!("`{}` = {value} is refused without its name: {}", p.name, e.message)),
        Ok(Ok(_)) => {}
    }
    let mut world = subject.block([4, 4, 3], &given, &subject.calm)?;
    let dt = world.stable_dt();
    let places = strained(&world, 1e-3);
    put(&mut world, &places, |x| x);
    let force = largest(&exact_forces(&mut world));
    let steady = dt > 0.0 && (dt.is_finite() || subject.world()?.stable_dt() == f64::INFINITY);
    let name = p.name;
    if steady && force.is_finite() {
        return match yielding(&mut world) {
            None => Ok(()),
            Some(mode) => fail(format!("`{name}` = {value} is taken, but then a body at rest gives way to {mode}")),
        };
    }
    fail(format!("`{name}` = {value} is taken, but then the largest force is {force} N and the stable step {dt} s"))
}

/// The small strain that the body does not resist, if there is one: stretched by it, forces must pull back.
fn yielding(world: &mut World) -> Option<&'static str> {
    let s = 1e-4;
    let modes = [
        ("dilatation", DMat3::from_diagonal(DVec3::splat(s))),
        ("shear", DMat3::from_cols(DVec3::new(0.0, s, 0.0), DVec3::new(s, 0.0, 0.0), DVec3::ZERO)),
        ("stretch", DMat3::from_diagonal(DVec3::new(s, -0.5 * s, -0.5 * s))),
    ];
    let rest = strained(world, 0.0);
    modes.into_iter().find_map(|(name, mode)| {
        put(world, &rest, |x| x + mode * x);
        let force = exact_forces(world);
        let work: f64 = force.iter().zip(&rest).map(|(f, x)| f.dot(mode * *x)).sum();
        (work >= 0.0 || work.is_nan()).then_some(name)
    })
}
