//! The page with a run inside, as one file that asks nobody for anything.
//!
//! Modules become `data:` addresses in an import map, because a page that was opened as a file may not load others.
//! Frames are what the server would send, in 16 bits, deflated (RFC 1950) and in base64; the page's worker unpacks them.

use std::io::Write;
use std::path::Path;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use fissure_io::atomic::write_atomically;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use rayon::prelude::*;
use serde_json::json;

use super::assets::{self, ASSETS};
use super::pack::{Pack, Precision};
use super::shown::Shown;
use crate::Error;

/// The file may run what is in it, and ask nobody.
const POLICY: &str = "default-src 'none'; script-src 'unsafe-inline' data:; worker-src blob:; style-src 'unsafe-inline'; \
    img-src data:; base-uri 'none'; form-action 'none'";

/// Writes every `every`th frame of the run in `dir`, the last one too, as a page into the file `out`, with `particles` or
/// without; gives how many those are, and how many bytes.
///
/// # Errors
/// No run in `dir`, frames that cannot be read, a file that cannot be written.
pub(crate) fn write(dir: &Path, every: usize, particles: bool, out: &Path) -> Result<(usize, usize), Error> {
    let run = Shown::open(dir)?;
    let mut listing = run.listing()?;
    let numbers = thinned(&run.numbers()?, every);
    if numbers.is_empty() {
        return Err(Error::Usage(format!("{} has no frames yet; let the run reach its first frame", dir.display())));
    }
    let there = if particles { run.particle_numbers()? } else { Vec::new() };
    let particles: Vec<u32> = there.into_iter().filter(|n| numbers.contains(n)).collect();
    listing["particles"] = particles.clone().into();
    let mut parts = vec![
        script("application/json", "runs", &json!({ "runs": [run.only(listing, &numbers)] }).to_string()),
        script("text/plain", "series-0", &run.series()?),
    ];
    let packed = |kind: &str, number: u32, pack: Result<Pack, Error>| {
        Ok(script("text/plain", &format!("{kind}-0-{number}"), &deflated(&pack?.into_bytes())))
    };
    let frames: Result<Vec<String>, Error> =
        numbers.par_iter().map(|&n| packed("frame", n, run.frame(n, Precision::Sixteen))).collect();
    parts.extend(frames?);
    let points: Result<Vec<String>, Error> =
        particles.par_iter().map(|&n| packed("particles", n, run.particles(n, Precision::Sixteen))).collect();
    parts.extend(points?);
    let page = page(&parts.concat());
    write_atomically(out, page.as_bytes()).map_err(Error::write(out))?;
    Ok((numbers.len(), page.len()))
}

/// Every `every`th of `numbers`, and the last.
fn thinned(numbers: &[u32], every: usize) -> Vec<u32> {
    let last = numbers.len().saturating_sub(1);
    let kept = numbers.iter().enumerate().filter(|(k, _)| k % every.max(1) == 0 || *k == last);
    kept.map(|(_, &number)| number).collect()
}

/// The page with `content` at its end.
fn page(content: &str) -> String {
    let text = |name: &str| assets::find(name).expect("a file of the page").text().into_owned();
    let modules: serde_json::Map<String, serde_json::Value> = ASSETS
        .iter()
        .filter(|asset| asset.name.ends_with(".js"))
        .map(|asset| {
            let code = BASE64_STANDARD.encode(named(&asset.text()));
            (format!("fissure/{}", asset.name), format!("data:text/javascript;base64,{code}").into())
        })
        .collect();
    let start = format!(
        "<script type=\"importmap\">{}</script>\n{content}{}<script type=\"module\">import 'fissure/app.js'</script>",
        json!({ "imports": modules }),
        script("text/plain", "worker", &text("worker.js"))
    );
    let policy = format!("<meta http-equiv=\"Content-Security-Policy\" content=\"{POLICY}\">\n");
    text("index.html")
        .replace("<meta charset=\"utf-8\">\n", &format!("<meta charset=\"utf-8\">\n{policy}"))
        .replace("<link rel=\"stylesheet\" href=\"style.css\">", &format!("<style>\n{}</style>", text("style.css")))
        .replace("<script type=\"module\" src=\"app.js\"></script>", &start)
}

/// `code` with files beside it called by the names of the import map: nothing lies beside a `data:` address.
fn named(code: &str) -> String {
    ASSETS.iter().fold(code.to_owned(), |code, asset| {
        let name = asset.name;
        code.replace(&format!("'./{name}'"), &format!("'fissure/{name}'"))
            .replace(&format!("\"./{name}\""), &format!("\"fissure/{name}\""))
    })
}

/// A script element with text that is not run. In JSON and in our code `<` stands in strings or before a blank only.
fn script(kind: &str, id: &str, text: &str) -> String {
    let text = if kind == "application/json" { text.replace('<', "\\u003c") } else { text.replace("</", "< /") };
    format!("<script type=\"{kind}\" id=\"{id}\">{text}</script>\n")
}

fn deflated(bytes: &[u8]) -> String {
    let mut encoder = ZlibEncoder::new(Vec::with_capacity(bytes.len() / 2), Compression::default());
    let done = encoder.write_all(bytes).and_then(|()| encoder.finish());
    BASE64_STANDARD.encode(done.expect("memory takes all"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinning_keeps_both_ends() {
        assert_eq!(thinned(&[0, 1, 2, 3, 7, 8], 2), [0, 2, 7, 8]);
        assert_eq!(thinned(&[0, 1, 2], 10), [0, 2]);
        assert_eq!(thinned(&[4], 3), [4]);
        assert!(thinned(&[], 3).is_empty());
    }

    #[test]
    fn the_page_asks_for_nothing_that_is_not_in_it() {
        let page = page("<i id=\"content\"></i>");
        assert!(page.contains("<i id=\"content\"></i>") && page.contains("Content-Security-Policy"));
        for outside in ["src=\"", "href=\"style", "from './"] {
            assert!(!page.contains(outside), "{outside}");
        }
        for asset in ASSETS.iter().filter(|asset| asset.name.ends_with(".js")) {
            let code = named(&asset.text());
            for beside in ["from './", "from \"./", "from\"./", "import './", "'three'"] {
                let found = code.split(beside).count() - 1;
                assert_eq!(found, 0, "{} asks for {beside}", asset.name);
            }
        }
    }

    #[test]
    fn nothing_ends_a_script_before_its_time() {
        assert_eq!(
            script("application/json", "a", "\"</script>\""),
            "<script type=\"application/json\" id=\"a\">\"\\u003c/script>\"</script>\n"
        );
        assert_eq!(script("text/plain", "b", "x</script>").matches("</script").count(), 1);
    }
}
