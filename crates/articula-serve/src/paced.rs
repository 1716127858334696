//! A connection that is written to at most at a rate, and ends when its client takes nothing.
#![allow(clippy::disallowed_methods, reason = "a rate needs a clock")]

use std::io::{Error, ErrorKind, IoSlice, Result};
use std::pin::Pin;
use std::task::{Context, Poll, ready};
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::time::{Instant, Sleep, sleep, sleep_until};

/// Share of a second whose bytes may be written at once.
const BURST_SECS: f64 = 0.05;
/// The same in bytes at least, about a packet.
const LEAST_BURST: f64 = 1500.0;

/// A stream with a rate and a patience.
#[derive(Debug)]
pub(crate) struct Paced<S> {
    stream: S,
    bucket: Option<Bucket>,
    /// Time for a client to take something.
    patience: Duration,
    /// When that is over, while it takes nothing.
    stall: Option<Pin<Box<Sleep>>>,
}

impl<S> Paced<S> {
    /// Without `bits_per_second` as fast as the client takes it.
    pub(crate) fn new(stream: S, bits_per_second: Option<f64>, patience: Duration) -> Self {
        Self {
            stream,
            bucket: bits_per_second.map(|bps| Bucket::new(bps / 8.0, Instant::now())),
            patience,
            stall: None,
        }
    }
}

impl<S> Paced<S> {
    /// Counts what was written, or the time in which nothing was.
    fn settled(
        &mut self,
        written: Poll<Result<usize>>,
        context: &mut Context<'_>,
    ) -> Poll<Result<usize>> {
        if let Poll::Ready(written) = written {
            self.stall = None;
            if let (Ok(written), Some(bucket)) = (&written, &mut self.bucket) {
                bucket.bytes -= *written as f64;
            }
            return Poll::Ready(written);
        }
        let patience = self.patience;
        let stall = self.stall.get_or_insert_with(|| Box::pin(sleep(patience)));
        ready!(stall.as_mut().poll(context));
        Poll::Ready(Err(Error::from(ErrorKind::TimedOut)))
    }
}

/// Bytes that may be written: a token bucket.
#[derive(Debug)]
struct Bucket {
    bytes_per_second: f64,
    /// Bytes that it holds, and when.
    bytes: f64,
    at: Instant,
    /// Until it holds some again.
    wait: Option<Pin<Box<Sleep>>>,
}

impl Bucket {
    fn new(bytes_per_second: f64, now: Instant) -> Self {
        let mut made = Self {
            bytes_per_second: bytes_per_second.max(1.0),
            bytes: 0.0,
            at: now,
            wait: None,
        };
        made.bytes = made.burst();
        made
    }

    fn burst(&self) -> f64 {
        (BURST_SECS * self.bytes_per_second).max(LEAST_BURST)
    }

    /// The number of bytes that may be written now, at least 1; else when there will be enough.
    fn allowed(&mut self, now: Instant) -> std::result::Result<usize, Instant> {
        let burst = self.burst();
        let more = self.bytes_per_second * (now - self.at).as_secs_f64();
        (self.bytes, self.at) = ((self.bytes + more).min(burst), now);
        // Few large writes in place of many small ones.
        let enough = burst / 2.0;
        match self.bytes >= enough {
            true => Ok(self.bytes as usize),
            false => {
                let secs = (enough - self.bytes) / self.bytes_per_second;
                Err(now + Duration::from_secs_f64(secs + 0.001))
            }
        }
    }

    fn poll(&mut self, context: &mut Context<'_>) -> Poll<usize> {
        loop {
            if let Some(wait) = &mut self.wait {
                ready!(wait.as_mut().poll(context));
                self.wait = None;
            }
            match self.allowed(Instant::now()) {
                Ok(bytes) => return Poll::Ready(bytes),
                Err(until) => self.wait = Some(Box::pin(sleep_until(until))),
            }
        }
    }
}

impl<S: AsyncRead + Unpin> AsyncRead for Paced<S> {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<Result<()>> {
        Pin::new(&mut self.stream).poll_read(context, buffer)
    }
}

impl<S: AsyncWrite + Unpin> AsyncWrite for Paced<S> {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<Result<usize>> {
        let this = &mut *self;
        let most = match &mut this.bucket {
            Some(bucket) => ready!(bucket.poll(context)),
            None => bytes.len(),
        };
        let part = &bytes[..bytes.len().min(most)];
        let written = Pin::new(&mut this.stream).poll_write(context, part);
        this.settled(written, context)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        parts: &[IoSlice<'_>],
    ) -> Poll<Result<usize>> {
        if self.bucket.is_some() {
            let first = parts.iter().find(|part| !part.is_empty());
            return self.poll_write(context, first.map_or(&[], |part| part));
        }
        let written = Pin::new(&mut self.stream).poll_write_vectored(context, parts);
        self.settled(written, context)
    }

    /// Without it, bodies would be copied behind their heads.
    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Result<()>> {
        Pin::new(&mut self.stream).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(context)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bucket_gives_its_burst_and_then_its_rate() {
        let start = Instant::now();
        let mut bucket = Bucket::new(100_000.0, start);
        let (mut now, mut written) = (start, 0);
        while now < start + Duration::from_secs(2) {
            match bucket.allowed(now) {
                Ok(bytes) => {
                    written += bytes;
                    bucket.bytes -= bytes as f64;
                }
                Err(until) => now = until,
            }
        }
        // The rate for two seconds, and one burst of 0.05 s.
        assert!((195_000..=205_100).contains(&written), "{written}");
    }
}
