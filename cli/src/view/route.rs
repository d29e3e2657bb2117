//! The addresses that there are. Nothing of an address reaches the file system but the number of a frame.

use super::assets::{self, Asset};

/// What an address means.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Route {
    /// A file of the page.
    Asset(&'static Asset),
    /// What runs there are and which frames they have.
    Runs,
    /// The series of a run.
    Series { run: usize },
    /// A frame of a run: surfaces and colliders.
    Frame { run: usize, number: u32 },
    /// The particles of a frame.
    Particles { run: usize, number: u32 },
}

impl Route {
    /// The route of `target`, which must begin with `token`, for so many runs.
    pub fn of(target: &str, token: &str, runs: usize) -> Option<Self> {
        let (given, path) = target.strip_prefix('/')?.split_once('/')?;
        if !same(given, token) {
            return None;
        }
        let run = |text: &str| number(text).map(|r| r as usize).filter(|&r| r < runs);
        let parts: Vec<&str> = path.split('/').collect();
        Some(match parts[..] {
            [""] => Self::Asset(assets::find("index.html")?),
            ["runs"] => Self::Runs,
            [name] => Self::Asset(assets::find(name)?),
            ["series", r] => Self::Series { run: run(r)? },
            ["frame", r, n] => Self::Frame { run: run(r)?, number: number(n)? },
            ["particles", r, n] => Self::Particles { run: run(r)?, number: number(n)? },
            _ => return None,
        })
    }
}

/// A number as we write it: digits alone, no zero before others.
fn number(text: &str) -> Option<u32> {
    let plain = text.bytes().all(|b| b.is_ascii_digit()) && (text == "0" || !text.starts_with('0'));
    if plain { text.parse().ok() } else { None }
}

/// Whether two texts are the same, in a time that tells nothing about where they differ.
fn same(a: &str, b: &str) -> bool {
    a.len() == b.len() && a.bytes().zip(b.bytes()).fold(0, |differ, (x, y)| differ | (x ^ y)) == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_addresses_lead_somewhere() {
        let of = |target| Route::of(target, "secret", 2);
        assert!(matches!(of("/secret/"), Some(Route::Asset(page)) if page.name == "index.html"));
        assert!(matches!(of("/secret/style.css"), Some(Route::Asset(style)) if style.kind.starts_with("text/css")));
        assert_eq!(of("/secret/runs"), Some(Route::Runs));
        assert_eq!(of("/secret/series/1"), Some(Route::Series { run: 1 }));
        assert_eq!(of("/secret/frame/0/12345"), Some(Route::Frame { run: 0, number: 12345 }));
        assert_eq!(of("/secret/particles/1/0"), Some(Route::Particles { run: 1, number: 0 }));
    }

    #[test]
    fn all_others_lead_nowhere() {
        for target in [
            "",
            "/",
            "secret/",
            "/secret",
            "/Secret/",
            "/secre/",
            "/secrets/",
            "/secret//",
            "//secret/",
            "/secret/?x",
            "/secret/../secret/",
            "/secret/scene.toml",
            "/secret/../../etc/passwd",
            "/secret/%2e%2e/scene.toml",
            "/secret/frame/2/0",
            "/secret/frame/0/01",
            "/secret/frame/0/+1",
            "/secret/frame/0/-1",
            "/secret/frame/0/",
            "/secret/frame/0/4294967296",
            "/secret/frame/0/1/",
            "/secret/frame/0/..",
            "/secret/frame/0/1%00",
            "/secret/frame/0/\u{661}",
            "/secret/series/1/0",
            "/secret/series/",
            "http://127.0.0.1/secret/",
        ] {
            assert_eq!(Route::of(target, "secret", 2), None, "{target}");
        }
    }
}
