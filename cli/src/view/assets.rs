//! The page, inside the program.

use std::borrow::Cow;

/// What a page that was served may do: use what is served beside it, and nothing else.
pub(super) const POLICY: &str = "default-src 'none'; script-src 'self'; worker-src 'self'; style-src 'self'; \
    connect-src 'self'; img-src 'self' data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// A file of the page.
#[derive(Debug, PartialEq)]
pub(super) struct Asset {
    pub name: &'static str,
    /// Its type, as HTTP says it.
    pub kind: &'static str,
    text: &'static str,
}

const HTML: &str = "text/html; charset=utf-8";
const CSS: &str = "text/css; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";

macro_rules! asset {
    ($name:literal, $kind:expr) => {
        Asset { name: $name, kind: $kind, text: include_str!(concat!("../../assets/view/", $name)) }
    };
    (three $name:literal) => {
        Asset { name: $name, kind: SCRIPT, text: include_str!(concat!("../../assets/view/three/", $name)) }
    };
}

/// All files of the page.
pub(super) static ASSETS: &[Asset] = &[
    asset!("index.html", HTML),
    asset!("style.css", CSS),
    asset!("app.js", SCRIPT),
    asset!("state.js", SCRIPT),
    asset!("data.js", SCRIPT),
    asset!("worker.js", SCRIPT),
    asset!("stage.js", SCRIPT),
    asset!("light.js", SCRIPT),
    asset!("body.js", SCRIPT),
    asset!("points.js", SCRIPT),
    asset!("colour.js", SCRIPT),
    asset!("difference.js", SCRIPT),
    asset!("legend.js", SCRIPT),
    asset!("timeline.js", SCRIPT),
    asset!("player.js", SCRIPT),
    asset!("plots.js", SCRIPT),
    asset!("series.js", SCRIPT),
    asset!("pick.js", SCRIPT),
    asset!("panel.js", SCRIPT),
    asset!("keys.js", SCRIPT),
    asset!(three "three.module.min.js"),
    asset!(three "three.core.min.js"),
    asset!(three "OrbitControls.js"),
];

/// The file called `name`.
pub(super) fn find(name: &str) -> Option<&'static Asset> {
    ASSETS.iter().find(|asset| asset.name == name)
}

impl Asset {
    /// What is in it. Controls of three.js ask for `three`, which needs a map in the page; here it lies beside them.
    pub fn text(&self) -> Cow<'static, str> {
        if self.name == "OrbitControls.js" {
            Cow::Owned(self.text.replace("'three'", "'./three.module.min.js'"))
        } else {
            Cow::Borrowed(self.text)
        }
    }
}
