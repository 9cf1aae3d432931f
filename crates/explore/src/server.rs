//! The server: connections, routes and limits.

use std::io;
use std::net::TcpListener;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use axum::Router;
use axum::extract::{DefaultBodyLimit, State};
use axum::http::header::CONTENT_TYPE;
use axum::middleware::from_fn_with_state;
use axum::response::{IntoResponse, Json, Response};
use axum::routing::{get, post};
use axum::serve::ListenerExt as _;
use serde::Deserialize;
use serde_json::{Value, json};
use slipmap_config::{About, LawText, check_names};
use tokio::sync::Semaphore;

use super::body::{JsonBody, LONGEST_BODY};
use super::guard::{Names, protect};
use super::plane::PlaneRequest;
use super::point::PointRequest;
use super::refusal::Refusal;
use super::{Start, assets, catalogue, law, place, quantities};

/// Time limit of an answer that the page waits for.
const LONGEST_WORK: Duration = Duration::from_secs(20);
/// Number of pictures computed at a time; each uses all cores.
const PICTURES: usize = 2;
/// Number of points and figures computed at a time.
const POINTS: usize = 4;
/// Interval between two checks of the flag that ends the server.
const LOOK: Duration = Duration::from_millis(50);
/// Time limit of unfinished work when the server ends.
const ENDING: Duration = Duration::from_millis(500);

/// State shared by all requests.
struct Shared {
    pictures: Arc<Semaphore>,
    points: Arc<Semaphore>,
    start: Start,
}

/// The state of all requests, as a handler receives it.
type OfPage = State<Arc<Shared>>;
/// The answer to a request in JSON.
type Reply = Result<Json<Value>, Refusal>;

/// Serves the page on `listener` until `stop` is set.
///
/// # Errors
/// Those of the listener, and of starting threads.
pub fn serve(listener: TcpListener, start: Start, stop: &AtomicBool) -> io::Result<()> {
    let port = listener.local_addr()?.port();
    listener.set_nonblocking(true)?;
    let shared = Arc::new(Shared {
        pictures: Arc::new(Semaphore::new(PICTURES)),
        points: Arc::new(Semaphore::new(POINTS)),
        start,
    });
    let router = routes(shared).layer(from_fn_with_state(Names::of_port(port), protect));
    let mut runtime = tokio::runtime::Builder::new_current_thread();
    runtime.enable_io().enable_time().max_blocking_threads(PICTURES + POINTS);
    let runtime = runtime.build()?;
    let ended = runtime.block_on(async {
        // Sends small answers at once.
        let listener = tokio::net::TcpListener::from_std(listener)?.tap_io(|stream| {
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

fn routes(shared: Arc<Shared>) -> Router {
    Router::new()
        .route("/", get(assets::page))
        .route("/assets/{name}", get(assets::file))
        .route("/api/catalogue", get(|| async { Json(catalogue::catalogue()) }))
        .route("/api/start", get(start))
        .route("/api/law", post(law))
        .route("/api/dimensionless", post(dimensionless))
        .route("/api/plane", post(plane))
        .route("/api/curves", post(curves))
        .route("/api/glance", post(glance))
        .route("/api/point", post(point))
        .route("/api/figure", post(figure))
        .route("/api/texts", post(texts))
        .fallback(|| async { Refusal::malformed("there is nothing here") })
        .layer(DefaultBodyLimit::max(LONGEST_BODY))
        .with_state(shared)
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
async fn carry_out<T: Send + 'static>(
    lane: &Arc<Semaphore>,
    work: impl FnOnce(&AtomicBool) -> Result<T, Refusal> + Send + 'static,
) -> Result<T, Refusal> {
    let to_the_end = async {
        let place = Arc::clone(lane).acquire_owned().await;
        let ticket = Ticket::default();
        let stop = Arc::clone(&ticket.0);
        let done = tokio::task::spawn_blocking(move || {
            let _place = place;
            work(&stop)
        });
        // A bug is told to the page that met it, and ends nothing else.
        let failed = |error| Err(Refusal::broken(format!("the computation failed: {error}")));
        done.await.unwrap_or_else(failed)
    };
    let answer = tokio::time::timeout(LONGEST_WORK, to_the_end).await;
    answer.unwrap_or_else(|_| Err(Refusal::out_of_time(LONGEST_WORK.as_secs())))
}

async fn start(State(shared): OfPage) -> Json<Value> {
    Json(shared.start.to_json())
}

/// A law that was typed or dropped; with a motion, the law of a machine.
#[derive(Deserialize)]
struct LawRequest {
    #[serde(flatten)]
    law: LawText,
    #[serde(default)]
    motion: Option<String>,
}

/// The axes of a law, or of a machine.
async fn law(JsonBody(request): JsonBody<LawRequest>) -> Reply {
    let (law, axes) = match &request.motion {
        None => {
            let law = law::law_of(&request.law, About::Oscillator)?;
            let axes = catalogue::axes(&law);
            (law, axes)
        }
        Some(motion) => {
            let motion = quantities::motion_of(motion)?;
            let law = law::law_of(&request.law, About::Machine(motion))?;
            check_names(&law)?;
            let axes = quantities::axes(&law, motion, &request.law.axes, request.law.holds_forces(&law));
            (law, axes)
        }
    };
    Ok(Json(json!({ "name": law.name(), "axes": axes })))
}

/// Converts a place to dimensionless numbers.
async fn dimensionless(JsonBody(request): JsonBody<place::Place>) -> Reply {
    let (law, point) = request.point()?;
    Ok(Json(json!({ "law": law::law_json(&law), "at": place::at_json(&law, &point) })))
}

async fn plane(
    State(shared): OfPage,
    JsonBody(request): JsonBody<PlaneRequest>,
) -> Result<Response, Refusal> {
    let picture = carry_out(&shared.pictures, move |stop| request.picture(stop)).await?;
    Ok(([(CONTENT_TYPE, "application/octet-stream")], picture).into_response())
}

async fn curves(State(shared): OfPage, JsonBody(request): JsonBody<PlaneRequest>) -> Reply {
    carry_out(&shared.pictures, move |stop| request.boundaries(stop)).await.map(Json)
}

async fn glance(State(shared): OfPage, JsonBody(request): JsonBody<PointRequest>) -> Reply {
    carry_out(&shared.points, move |_| request.glance()).await.map(Json)
}

async fn point(State(shared): OfPage, JsonBody(request): JsonBody<PointRequest>) -> Reply {
    carry_out(&shared.points, move |_| request.probe()).await.map(Json)
}

async fn figure(State(shared): OfPage, JsonBody(request): JsonBody<PointRequest>) -> Reply {
    carry_out(&shared.points, move |stop| request.figure(stop)).await.map(Json)
}

async fn texts(State(shared): OfPage, JsonBody(request): JsonBody<PlaneRequest>) -> Reply {
    carry_out(&shared.points, move |_| request.texts()).await.map(Json)
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;

    use super::*;

    #[test]
    fn what_panics_is_answered() {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_time().build().unwrap();
        let work = |_: &AtomicBool| -> Result<&str, Refusal> { panic!("a bug") };
        let refusal = runtime.block_on(carry_out(&Arc::new(Semaphore::new(1)), work)).unwrap_err();
        assert!(format!("{refusal:?}").contains("the computation failed"), "{refusal:?}");
    }

    #[test]
    fn work_keeps_its_place_until_it_ends_though_nobody_waits_for_it() {
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
                    Ok(())
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
