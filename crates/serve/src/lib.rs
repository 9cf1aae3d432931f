//! The local server of the page of `slipmap explore`: connections, the secret, and who computes when.
//!
//! It listens on the loopback address, where every user of the computer and every page in a browser can send requests.
//! It answers those alone whose path begins with a secret that is made anew at each start.

// Only the program and its tests use this crate.
#![allow(missing_docs)]

use std::io;
use std::net::TcpListener;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use axum::Router;
use axum::body::to_bytes;
use axum::extract::{Request, State};
use axum::http::header::{
    CACHE_CONTROL, CONTENT_TYPE, REFERRER_POLICY, X_CONTENT_TYPE_OPTIONS, X_FRAME_OPTIONS,
};
use axum::http::{HeaderValue, Method, StatusCode};
use axum::response::{IntoResponse, Response};
use axum::serve::ListenerExt as _;
use slipmap_explore::{Engine, LONGEST_BODY, Refusal, Start, ask, page};
use tokio::sync::Semaphore;

/// Time limit of an answer that the page waits for.
const LONGEST_WORK: Duration = Duration::from_secs(20);
/// Number of pictures computed at a time, each of which uses all cores; of points and figures; of small answers, which wait for
/// none of the others.
const PICTURES: usize = 2;
const POINTS: usize = 4;
const SMALL: usize = 2;
/// Interval between two checks of the flag that ends the server.
const LOOK: Duration = Duration::from_millis(50);
/// Time limit of unfinished work when the server ends.
const ENDING: Duration = Duration::from_millis(500);

/// A server that listens.
pub struct Server {
    listener: TcpListener,
    port: u16,
    /// The path of the page, which begins and ends with a slash.
    path: String,
}

/// State shared by all requests.
struct Shared {
    path: String,
    page: String,
    pictures: Arc<Semaphore>,
    points: Arc<Semaphore>,
    small: Arc<Semaphore>,
}

impl Server {
    /// # Errors
    /// Those of the listener, and of the system's random numbers.
    pub fn new(listener: TcpListener) -> io::Result<Self> {
        let mut secret = [0; 16];
        getrandom::fill(&mut secret).map_err(io::Error::other)?;
        let secret = u128::from_le_bytes(secret);
        listener.set_nonblocking(true)?;
        let port = listener.local_addr()?.port();
        Ok(Self { listener, port, path: format!("/{secret:032x}/") })
    }

    /// The address of the page: whoever knows it may ask.
    #[must_use]
    pub fn address(&self) -> String {
        format!("http://127.0.0.1:{}{}", self.port, self.path)
    }

    /// Serves the page that begins with `start` until `stop` is set.
    ///
    /// # Errors
    /// Those of the listener, and of starting threads.
    pub fn run(self, start: &Start, stop: &AtomicBool) -> io::Result<()> {
        let lane = |places| Arc::new(Semaphore::new(places));
        let shared = Shared {
            page: page(start, Engine::Server(&self.path)),
            path: self.path,
            pictures: lane(PICTURES),
            points: lane(POINTS),
            small: lane(SMALL),
        };
        let router = Router::new().fallback(respond).with_state(Arc::new(shared));
        let mut runtime = tokio::runtime::Builder::new_current_thread();
        runtime.enable_io().enable_time().max_blocking_threads(PICTURES + POINTS + SMALL);
        let runtime = runtime.build()?;
        let ended = runtime.block_on(async {
            // Sends small answers at once.
            let listener = tokio::net::TcpListener::from_std(self.listener)?.tap_io(|stream| {
                let _ = stream.set_nodelay(true);
            });
            tokio::spawn(axum::serve(listener, router).into_future());
            while !stop.load(Ordering::Relaxed) {
                tokio::time::sleep(LOOK).await;
            }
            Ok(())
        });
        runtime.shutdown_timeout(ENDING);
        ended
    }
}

async fn respond(State(shared): State<Arc<Shared>>, request: Request) -> Response {
    let mut response = match request.uri().path().strip_prefix(&shared.path) {
        None => StatusCode::NOT_FOUND.into_response(),
        Some("") if request.method() == Method::GET => {
            ([(CONTENT_TYPE, "text/html; charset=utf-8")], shared.page.clone()).into_response()
        }
        Some(path) if request.method() == Method::POST => {
            let (status, answer) = answered(&shared, path.to_owned(), request).await;
            let status = StatusCode::from_u16(status).unwrap_or(StatusCode::INTERNAL_SERVER_ERROR);
            (status, [(CONTENT_TYPE, "application/octet-stream")], answer).into_response()
        }
        Some(_) => StatusCode::METHOD_NOT_ALLOWED.into_response(),
    };
    let headers = response.headers_mut();
    // The page itself says what it may load.
    for (name, value) in [
        (X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (X_FRAME_OPTIONS, "DENY"),
        (REFERRER_POLICY, "no-referrer"),
        (CACHE_CONTROL, "no-store"),
    ] {
        headers.insert(name, HeaderValue::from_static(value));
    }
    response
}

async fn answered(shared: &Shared, path: String, request: Request) -> (u16, Vec<u8>) {
    let Ok(body) = to_bytes(request.into_body(), LONGEST_BODY).await else {
        return Refusal::too_long(LONGEST_BODY).answer();
    };
    let lane = match path.as_str() {
        "plane" | "curves" => &shared.pictures,
        "point" | "figure" | "glance" => &shared.points,
        _ => &shared.small,
    };
    carry_out(lane, move |stop| ask(&path, &body, stop)).await
}

/// Tells work to stop once nobody waits for its answer: the page has closed the connection, or time is up.
#[derive(Default)]
struct Ticket(Arc<AtomicBool>);

impl Drop for Ticket {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Runs the work of a request on its own thread as long as it is waited for, within the time limit. Work that
/// cannot stop at once keeps its permit, so that a lane never runs more work than it has permits.
async fn carry_out(
    lane: &Arc<Semaphore>,
    work: impl FnOnce(&AtomicBool) -> (u16, Vec<u8>) + Send + 'static,
) -> (u16, Vec<u8>) {
    let to_the_end = async {
        let place = Arc::clone(lane).acquire_owned().await;
        let ticket = Ticket::default();
        let stop = Arc::clone(&ticket.0);
        let done = tokio::task::spawn_blocking(move || {
            let _place = place;
            work(&stop)
        });
        // A bug is told to the page that met it, and ends nothing else.
        done.await
            .unwrap_or_else(|error| Refusal::broken(format!("the computation failed: {error}")).answer())
    };
    let answer = tokio::time::timeout(LONGEST_WORK, to_the_end).await;
    answer.unwrap_or_else(|_| Refusal::out_of_time(LONGEST_WORK.as_secs()).answer())
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;

    use super::*;

    #[test]
    fn what_panics_is_answered() {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_time().build().unwrap();
        let work = |_: &AtomicBool| -> (u16, Vec<u8>) { panic!("a bug") };
        let (status, answer) = runtime.block_on(carry_out(&Arc::new(Semaphore::new(1)), work));
        let answer = String::from_utf8(answer).unwrap();
        assert!(status == 500 && answer.contains("the computation failed"), "{answer}");
    }

    #[test]
    fn work_keeps_its_place_though_nobody_waits() {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_time().build().unwrap();
        let (begin, begun) = channel();
        let (end, ended) = channel();
        runtime.block_on(async {
            let lane = Arc::new(Semaphore::new(1));
            let of_client = Arc::clone(&lane);
            let client = tokio::spawn(async move {
                let work = move |_: &AtomicBool| {
                    begin.send(()).unwrap();
                    ended.recv().unwrap();
                    (200, Vec::new())
                };
                carry_out(&of_client, work).await
            });
            tokio::task::spawn_blocking(move || begun.recv().unwrap()).await.unwrap();
            client.abort();
            assert!(client.await.unwrap_err().is_cancelled());
            assert_eq!(lane.available_permits(), 0, "it still works");
            end.send(()).unwrap();
            let _place = lane.acquire().await.unwrap();
        });
    }
}
