//! A server for one person on this machine: GET, one answer to a connection.
//!
//! On the standard library alone: what is asked here is one line and one header, and the crates for it either bring an
//! asynchronous runtime or read lines of any length. It answers only those who know the token, which is in the address
//! that is printed, and only by the names of this machine, so that no page from elsewhere can have a browser ask
//! (DNS rebinding). A browser opens connections ahead of need and says nothing on them, so each has a thread.

use std::fmt::Write as _;
use std::io::{Read, Write};
use std::net::{Ipv4Addr, Shutdown, TcpListener, TcpStream};
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::assets::POLICY;
use super::pack::{Pack, Precision::Full as FULL};
use super::request::{Refusal, Request};
use super::route::Route;
use super::shown::{self, Shown};
use crate::Error;

/// Connections at a time; further ones are closed at once.
const MOST: usize = 64;
/// How long a browser may take to ask, or to take an answer in.
const PATIENCE: Duration = Duration::from_secs(10);

/// A server that listens.
pub(super) struct Server {
    listener: TcpListener,
    url: String,
    shared: Arc<Shared>,
}

/// What all connections know.
struct Shared {
    token: String,
    /// The names by which a browser on this machine may call it.
    hosts: [String; 2],
    runs: Vec<Shown>,
}

/// An answer.
struct Answer {
    status: &'static str,
    kind: &'static str,
    body: Vec<u8>,
}

impl Server {
    /// Listens on 127.0.0.1, on `port` or, for 0, any that is free.
    pub fn start(port: u16, runs: Vec<Shown>) -> Result<Self, Error> {
        let failed = |e: std::io::Error| {
            Error::Usage(format!("port {port} of 127.0.0.1 cannot be had ({e}); leave --port out for any that is free"))
        };
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(failed)?;
        let port = listener.local_addr().map_err(failed)?.port();
        let mut random = [0; 16];
        getrandom::fill(&mut random).map_err(|e| Error::Usage(format!("the system gives no random numbers ({e})")))?;
        let token = random.iter().fold(String::new(), |mut text, byte| {
            let _ = write!(text, "{byte:02x}");
            text
        });
        let url = format!("http://127.0.0.1:{port}/{token}/");
        let hosts = [format!("127.0.0.1:{port}"), format!("localhost:{port}")];
        Ok(Self { listener, url, shared: Arc::new(Shared { token, hosts, runs }) })
    }

    /// The address of the page.
    pub fn url(&self) -> &str {
        &self.url
    }

    /// Answers until the program ends.
    pub fn serve(self) {
        for stream in self.listener.incoming().flatten() {
            // every connection holds one
            if Arc::strong_count(&self.shared) > MOST {
                continue;
            }
            let shared = self.shared.clone();
            let thread = std::thread::Builder::new().name("view".into());
            // a browser that went away is nobody's trouble, and one that gets no thread asks again
            let _ = thread.spawn(move || shared.attend(stream));
        }
    }
}

impl Shared {
    fn attend(&self, mut stream: TcpStream) -> std::io::Result<()> {
        stream.set_read_timeout(Some(PATIENCE))?;
        stream.set_write_timeout(Some(PATIENCE))?;
        let answer = match Request::read(&mut stream, Instant::now() + PATIENCE) {
            Ok(request) => self.answer(&request),
            Err(Refusal::Long) => Answer::refusal("431 Request Header Fields Too Large", "The request is too long."),
            Err(Refusal::Malformed) => Answer::refusal("400 Bad Request", "This is no request of a browser."),
            Err(Refusal::Gone) => return Ok(()),
        };
        stream.write_all(answer.head().as_bytes())?;
        stream.write_all(&answer.body)?;
        stream.shutdown(Shutdown::Write)?;
        // closed with something unread, the answer would be lost to whoever is still asking
        stream.set_read_timeout(Some(Duration::from_millis(200)))?;
        let mut rest = [0; 4096];
        for _ in 0..64 {
            if stream.read(&mut rest)? == 0 {
                break;
            }
        }
        Ok(())
    }

    fn answer(&self, request: &Request) -> Answer {
        if !self.hosts.iter().any(|host| request.host.eq_ignore_ascii_case(host)) {
            return Answer::refusal("421 Misdirected Request", "Only requests from this machine are answered.");
        }
        if request.method != "GET" {
            return Answer::refusal("405 Method Not Allowed", "There is nothing here to change.");
        }
        let Some(route) = Route::of(&request.target, &self.token, self.runs.len()) else {
            return Answer::refusal("404 Not Found", "There is nothing here; give the whole address that was printed.");
        };
        let answered = match route {
            Route::Asset(asset) => {
                Ok(Answer { status: "200 OK", kind: asset.kind, body: asset.text().into_owned().into() })
            }
            Route::Runs => shown::listing(&self.runs).map(Answer::json),
            Route::Series { run } => self.runs[run].series().map(Answer::text),
            Route::Frame { run, number } => self.runs[run].frame(number, FULL).map(Answer::binary),
            Route::Particles { run, number } => self.runs[run].particles(number, FULL).map(Answer::binary),
        };
        answered.unwrap_or_else(|error| Answer::refusal("404 Not Found", &error.to_string()))
    }
}

impl Answer {
    fn refusal(status: &'static str, sentence: &str) -> Self {
        Self { status, kind: "text/plain; charset=utf-8", body: format!("{sentence}\n").into() }
    }

    fn json(text: String) -> Self {
        Self { status: "200 OK", kind: "application/json", body: text.into() }
    }

    fn text(text: String) -> Self {
        Self { status: "200 OK", kind: "text/plain; charset=utf-8", body: text.into() }
    }

    fn binary(pack: Pack) -> Self {
        Self { status: "200 OK", kind: "application/octet-stream", body: pack.into_bytes() }
    }

    /// Everything before the body. Nothing is kept, framed, sniffed, or told to others.
    fn head(&self) -> String {
        format!(
            "HTTP/1.1 {}\r\nContent-Type: {}\r\nContent-Length: {}\r\nConnection: close\r\nCache-Control: no-store\r\n\
             Content-Security-Policy: {POLICY}\r\nReferrer-Policy: no-referrer\r\nX-Content-Type-Options: nosniff\r\n\
             Cross-Origin-Resource-Policy: same-origin\r\nCross-Origin-Opener-Policy: same-origin\r\n\r\n",
            self.status,
            self.kind,
            self.body.len()
        )
    }
}
