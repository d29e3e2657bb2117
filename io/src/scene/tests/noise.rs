//! Damaged scenes and overrides are answered, never with a panic.

use super::*;

/// A number from a counter (splitmix64).
fn random(state: &mut u64) -> usize {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 1) as usize
}

const SCRAPS: &[&str] = &[
    "nan",
    "-inf",
    "1e999",
    "-0.0",
    "[",
    "]",
    "{",
    "}",
    "=",
    "'",
    "\"",
    "\n",
    ".",
    ",",
    "[[",
    "true",
    "9223372036854775807",
    "1e-320",
    "[1, 2]",
    "[[]]",
    "{}",
    "\u{0}",
    "é",
    "κ = 1",
    "[body]",
    "[body.a]",
    "[[anchor]]",
    "[output.picture]",
    "0",
    "0.5",
    "[1, 2, 3]",
    "1",
    "2",
    "",
];

#[test]
fn two_thousand_damaged_scenes_do_not_panic() {
    let mut state = 1;
    let (mut read, mut refused) = (0, 0);
    for _ in 0..2000 {
        let mut chars: Vec<char> = FULL.chars().collect();
        for _ in 0..1 + random(&mut state) % 4 / 3 {
            let at = random(&mut state) % chars.len();
            let scrap = SCRAPS[random(&mut state) % SCRAPS.len()];
            match random(&mut state) % 4 {
                0 => chars[at] = char::from_u32(random(&mut state) as u32 % 128).unwrap_or('x'),
                1 => drop(chars.splice(at..at, scrap.chars())),
                2 => drop(chars.drain(at..(at + 1 + random(&mut state) % 12).min(chars.len()))),
                _ => {
                    // a whole value goes, so that most of these stay valid TOML
                    let from = chars[at..].iter().position(|&c| c == '=').map_or(at, |k| at + k + 1);
                    let to = chars[from..].iter().position(|&c| c == '\n').map_or(chars.len(), |k| from + k);
                    drop(chars.splice(from..to, scrap.chars()));
                }
            }
        }
        let text: String = chars.into_iter().collect();
        let key = keys()[random(&mut state) % keys().len()].path.replace("NAME", "second").replace(".N", ".2");
        let set = format!("{key}={}", SCRAPS[random(&mut state) % SCRAPS.len()]);
        let set = std::slice::from_ref(&set);
        for (text, sets) in [(text.as_str(), &[][..]), (&text, set), (FULL, set)] {
            match Scene::parse(text, Path::new("x.toml"), sets) {
                Ok(scene) => {
                    read += 1;
                    assert_eq!(parse(scene.text()).unwrap().fingerprint(), scene.fingerprint(), "{sets:?}\n{text}");
                }
                Err(error) => {
                    refused += 1;
                    assert_eq!(error.to_string().lines().count(), 1, "{error}");
                }
            }
        }
    }
    // both happen, so the test tests something; measured 381 read

    assert!(read > 200 && refused > 1000, "{read} read, {refused} refused");
}

#[test]
fn deep_nesting_is_refused_and_does_not_overflow_the_stack() {
    let deep = 50_000;
    let dotted = "a.".repeat(deep);
    let texts = [
        format!("[{dotted}a]\n"),
        format!("{dotted}a = 1\n"),
        format!("gravity = {}\n", "[".repeat(deep)),
        format!("gravity = {}{}\n", "[".repeat(deep), "]".repeat(deep)),
        format!("gravity = {}\n", "{a=".repeat(deep)),
    ];
    for text in &texts {
        assert!(matches!(parse(text), Err(SceneError::Syntax { .. } | SceneError::Wrong { .. })));
    }
    let sets = [format!("{dotted}a=1"), format!("gravity={}{}", "[".repeat(deep), "]".repeat(deep))];
    for set in sets {
        assert!(matches!(with(FULL, &[&set]), Err(SceneError::Wrong { .. })));
    }
}
