//! What a browser asks: the head of one HTTP/1.1 request (RFC 9112), within bounds.

use std::io::Read;
use std::time::Instant;

/// Bytes that a request may take. A browser's take about 600.
const LONGEST: usize = 8 << 10;

/// The parts of a request that matter here.
#[derive(Debug, PartialEq)]
pub(super) struct Request {
    pub method: String,
    /// As sent: a path that is not exactly one of ours is nobody's.
    pub target: String,
    pub host: String,
}

/// Why there is no request.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Refusal {
    /// Longer than [`LONGEST`].
    Long,
    /// Not HTTP, or without exactly one host.
    Malformed,
    /// It ended early, or took too long.
    Gone,
}

impl Request {
    /// Reads up to the empty line, or gives up at `deadline`; each read is expected to time out by itself.
    pub fn read(from: &mut impl Read, deadline: Instant) -> Result<Self, Refusal> {
        let mut bytes = Vec::with_capacity(1024);
        let mut part = [0; 1024];
        loop {
            if let Some(end) = bytes.windows(4).position(|w| w == b"\r\n\r\n") {
                return Self::parse(&bytes[..end]);
            }
            if bytes.len() >= LONGEST {
                return Err(Refusal::Long);
            }
            match from.read(&mut part) {
                Ok(n) if n > 0 && Instant::now() < deadline => bytes.extend_from_slice(&part[..n]),
                _ => return Err(Refusal::Gone),
            }
        }
    }

    fn parse(head: &[u8]) -> Result<Self, Refusal> {
        let text = std::str::from_utf8(head).map_err(|_| Refusal::Malformed)?;
        let mut lines = text.split("\r\n");
        let words: Vec<&str> = lines.next().unwrap_or_default().split(' ').collect();
        let [method, target, "HTTP/1.1" | "HTTP/1.0"] = words[..] else {
            return Err(Refusal::Malformed);
        };
        let mut hosts = lines.filter_map(|line| {
            let (name, value) = line.split_once(':')?;
            name.eq_ignore_ascii_case("host").then_some(value.trim())
        });
        match (hosts.next(), hosts.next()) {
            (Some(host), None) => Ok(Self { method: method.into(), target: target.into(), host: host.into() }),
            _ => Err(Refusal::Malformed),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    fn read(bytes: &[u8]) -> Result<Request, Refusal> {
        Request::read(&mut &bytes[..], Instant::now() + Duration::from_secs(60))
    }

    #[test]
    fn a_browser_is_understood() {
        let request = read(b"GET /a/b?c HTTP/1.1\r\nAccept: */*\r\nhOST:  127.0.0.1:80 \r\n\r\nbody").unwrap();
        assert_eq!((&*request.method, &*request.target, &*request.host), ("GET", "/a/b?c", "127.0.0.1:80"));
    }

    #[test]
    fn anything_else_is_refused_by_its_kind() {
        let long = [b"GET /".as_slice(), &[b'a'; 2 * LONGEST]].concat();
        for (bytes, why) in [
            (b"".as_slice(), Refusal::Gone),
            (b"GET / HTTP/1.1\r\nHost: x\r\n", Refusal::Gone),
            (b"GET / HTTP/1.1\r\n\r\n", Refusal::Malformed),
            (b"GET / HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n", Refusal::Malformed),
            (b"GET /  HTTP/1.1\r\nHost: a\r\n\r\n", Refusal::Malformed),
            (b"GET / HTTP/2\r\nHost: a\r\n\r\n", Refusal::Malformed),
            (b"\x16\x03\x01\xff\r\n\r\n", Refusal::Malformed),
            (&long, Refusal::Long),
        ] {
            assert_eq!(read(bytes), Err(why), "{:?}", String::from_utf8_lossy(bytes));
        }
        let late = Request::read(&mut &b"GET / HTTP/1.1\r\nHost: a\r\n\r\n"[..], Instant::now());
        assert_eq!(late, Err(Refusal::Gone));
    }
}
