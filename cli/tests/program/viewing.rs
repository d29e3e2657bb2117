//! `fissure view`: what is served, and to whom; `export --to html`.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::Child;

use crate::workshop::Workshop;

/// A server that ends with the test.
struct Server {
    child: Child,
    port: u16,
    token: String,
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Status, head and body.
struct Reply {
    status: u16,
    head: String,
    body: Vec<u8>,
}

impl Server {
    fn start(shop: &Workshop, runs: &[&str]) -> Self {
        let mut child = shop.start(&[&["view"], runs].concat());
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let address = line.trim_end().strip_prefix("http://127.0.0.1:").unwrap_or_else(|| panic!("{line}"));
        let (port, token) = address.trim_end_matches('/').split_once('/').unwrap();
        Self { child, port: port.parse().unwrap(), token: token.to_owned() }
    }

    /// Sends `bytes` as they are; gives what comes back until the connection ends.
    fn raw(&self, bytes: &[u8]) -> Vec<u8> {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream.write_all(bytes).unwrap();
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).unwrap();
        answer
    }

    fn ask(&self, method: &str, target: &str, host: &str) -> Reply {
        let answer = self.raw(format!("{method} {target} HTTP/1.1\r\nHost: {host}\r\n\r\n").as_bytes());
        let end = answer.windows(4).position(|w| w == b"\r\n\r\n").unwrap();
        let head = String::from_utf8(answer[..end].to_vec()).unwrap();
        Reply { status: head[9..12].parse().unwrap(), head, body: answer[end + 4..].to_vec() }
    }

    fn get(&self, path: &str) -> Reply {
        self.ask("GET", &format!("/{}/{path}", self.token), &format!("127.0.0.1:{}", self.port))
    }
}

/// A short run with a collider.
fn shop_with_runs(runs: &[&str]) -> Workshop {
    let shop = Workshop::new();
    for run in runs {
        shop.good(&[
            "run",
            "box.toml",
            "--out",
            run,
            "--quiet",
            "--set",
            "duration=0.02",
            "--set",
            "body.box.tets=300",
        ]);
    }
    shop
}

#[test]
fn the_page_its_frames_and_nothing_else() {
    let shop = shop_with_runs(&["a", "b"]);
    let server = Server::start(&shop, &["a", "b"]);
    assert_eq!(server.token.len(), 32);

    let page = server.get("");
    assert_eq!(page.status, 200);
    assert!(page.head.contains("Content-Type: text/html") && page.head.contains("default-src 'none'"), "{}", page.head);
    assert!(!page.head.contains("unsafe"), "{}", page.head);
    for file in ["style.css", "app.js", "worker.js", "three.module.min.js", "three.core.min.js", "OrbitControls.js"] {
        let got = server.get(file);
        assert!(got.status == 200 && got.body.len() > 1000, "{file}: {}", got.status);
        assert!(got.head.contains(if file.ends_with("css") { "text/css" } else { "text/javascript" }), "{file}");
    }

    let listing: serde_json::Value = serde_json::from_slice(&server.get("runs").body).unwrap();
    let run = &listing["runs"][1];
    assert_eq!((&run["name"], &run["title"]), (&"b".into(), &"A box breaks".into()));
    assert_eq!(run["frames"], serde_json::json!([0, 1, 2]));
    assert_eq!(run["times"][2], shop.frame("b", 2).time);

    for path in [
        "scene.toml",
        "../scene.toml",
        "..%2fscene.toml",
        "frames/frame_0000.ply",
        "frame/0/../../scene.toml",
        "frame/0/7",
        "frame/2/0",
        "particles/0/7",
        "/etc/passwd",
        "frame/0/0?x",
        "index.html/",
    ] {
        assert_eq!(server.get(path).status, 404, "{path}");
    }
}

#[test]
fn frames_come_with_all_their_columns() {
    let shop = shop_with_runs(&["a"]);
    let server = Server::start(&shop, &["a"]);
    let frame = shop.frame("a", 2);
    let body = server.get("frame/0/2").body;
    let length = u32::from_le_bytes(body[..4].try_into().unwrap()) as usize;
    assert_eq!((4 + length) % 8, 0);
    let head: serde_json::Value = serde_json::from_slice(&body[4..4 + length]).unwrap();
    assert_eq!((head["number"].as_u64(), head["time"].as_f64()), (Some(2), Some(frame.time)));
    let column = |name: &str, size: usize| {
        let about = &head["columns"][name];
        let number = |key: &str| about[key].as_u64().unwrap() as usize;
        let start = 4 + length + number("at");
        &body[start..start + number("count") * number("per") * size]
    };
    let positions: &[u8] = column("position", 4);
    let wanted: Vec<u8> = frame.positions.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
    assert_eq!(positions, wanted);
    assert_eq!(column("inside", 1), frame.inside);
    let ids: Vec<u32> = column("id", 2).chunks(2).map(|b| u16::from_le_bytes([b[0], b[1]]).into()).collect();
    assert_eq!(ids, frame.id);
    // the same triangles, crack faces last
    let corners: Vec<u32> = column("triangle", 2).chunks(2).map(|b| u16::from_le_bytes([b[0], b[1]]).into()).collect();
    let (mut sent, mut kept) = (corners.as_chunks::<3>().0.to_vec(), frame.triangles.clone());
    let crack = |t: &[u32; 3]| t.iter().all(|&v| frame.inside[v as usize] == 1);
    let outer = head["outer"].as_u64().unwrap() as usize;
    assert!(outer > 0 && outer < sent.len());
    assert!(sent[..outer].iter().all(|t| !crack(t)) && sent[outer..].iter().all(crack));
    sent.sort_unstable();
    kept.sort_unstable();
    assert_eq!(sent, kept);

    let particles = server.get("particles/0/2");
    assert_eq!(particles.status, 200);
    assert!(String::from_utf8_lossy(&particles.body[..600]).contains("\"width\""));
}

#[test]
fn only_this_machine_with_the_token_is_answered() {
    let shop = shop_with_runs(&["a"]);
    let server = Server::start(&shop, &["a"]);
    let (port, page) = (server.port, format!("/{}/", server.token));
    for host in [format!("127.0.0.1:{port}"), format!("localhost:{port}"), format!("LOCALHOST:{port}")] {
        assert_eq!(server.ask("GET", &page, &host).status, 200, "{host}");
    }
    for host in
        ["", "127.0.0.1", "evil.example", &format!("evil.example:{port}"), "127.0.0.1:1", "[::1]:80", "localhost"]
    {
        assert_eq!(server.ask("GET", &page, host).status, 421, "{host}");
    }
    let host = format!("127.0.0.1:{port}");
    let other = "0".repeat(32);
    for target in
        ["/", "/runs", "/index.html", &format!("/{other}/"), &page[..20], &page.to_uppercase().replace(['0'], "1")]
    {
        let reply = server.ask("GET", target, &host);
        assert_eq!(reply.status, 404, "{target}");
        assert!(!String::from_utf8_lossy(&reply.body).contains(&server.token));
    }
    for method in ["HEAD", "POST", "PUT", "DELETE", "OPTIONS", "get"] {
        assert_eq!(server.ask(method, &page, &host).status, 405, "{method}");
    }
    let long = format!("GET {page}{} HTTP/1.1\r\nHost: {host}\r\n\r\n", "a".repeat(20_000));
    assert!(server.raw(long.as_bytes()).starts_with(b"HTTP/1.1 431 "));
    for bad in ["", "\r\n\r\n", "nonsense\r\n\r\n", "GET / HTTP/1.1\r\n\r\n"] {
        let mut stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
        stream.write_all(bad.as_bytes()).unwrap();
        stream.shutdown(std::net::Shutdown::Write).unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        assert!(answer.is_empty() || answer.starts_with("HTTP/1.1 400 "), "{bad}: {answer}");
    }
    // connections that say nothing, as browsers open them ahead of need, keep nobody waiting
    let _silent: Vec<TcpStream> = (0..20).map(|_| TcpStream::connect(("127.0.0.1", port)).unwrap()).collect();
    assert_eq!(server.get("runs").status, 200);
}

#[test]
fn what_cannot_be_shown_is_said() {
    let shop = Workshop::new();
    let sentence = shop.refusal(&["view", "."]);
    assert!(sentence.contains("is no run folder"), "{sentence}");
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port().to_string();
    shop.good(&["run", "box.toml", "--out", "a", "--quiet", "--set", "duration=0.001", "--set", "body.box.tets=300"]);
    let sentence = shop.refusal(&["view", "a", "--port", &port]);
    assert!(sentence.contains(&port) && sentence.contains("leave --port out"), "{sentence}");
}

#[test]
fn a_run_becomes_one_file_that_asks_for_nothing() {
    let shop = shop_with_runs(&["a"]);
    let answer = shop.good(&["export", "a", "--to", "html"]);
    assert!(answer.out.starts_with("a/run.html: 3 frames, "), "{answer}");
    let page = std::fs::read_to_string(shop.path("a/run.html")).unwrap();
    for there in
        ["Content-Security-Policy", "id=\"frame-0-0\"", "id=\"frame-0-2\"", "id=\"particles-0-1\"", "A box breaks"]
    {
        assert!(page.contains(there), "{there}");
    }
    for elsewhere in ["src=\"", "http-equiv=\"refresh", "href=\"style"] {
        assert!(!page.contains(elsewhere), "{elsewhere}");
    }
    shop.good(&["export", "a", "--to", "html", "--every", "2", "--out", "thin.html"]);
    let thin = std::fs::read_to_string(shop.path("thin.html")).unwrap();
    assert!(thin.contains("id=\"frame-0-2\"") && !thin.contains("id=\"frame-0-1\"") && thin.len() < page.len());
    shop.good(&["export", "a", "--to", "html", "--no-particles", "--out", "surface.html"]);
    let surface = std::fs::read_to_string(shop.path("surface.html")).unwrap();
    assert!(page.contains("id=\"particles-0-0\"") && !surface.contains("id=\"particles-"));
    assert!(surface.contains("\"particles\":[]"), "the page offers none");
    assert!(shop.refusal(&["export", "a/scene.toml", "--to", "html"]).contains("give its folder"));
}
