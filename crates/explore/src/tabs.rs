//! Supersedes requests: of the requests of one tab about the same topic only the latest is computed.

use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use serde::Deserialize;

use super::refusal::Refusal;

/// Largest number of tabs and topics remembered; the one whose last request is oldest is forgotten first.
const MOST: usize = 256;
/// Largest number of characters of a tab's name.
const LONGEST_NAME: usize = 40;

/// Tab and number of a request; numbers increase from request to request.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct Turn {
    tab: String,
    number: u64,
}

/// The latest request of each tab about each topic.
#[derive(Debug, Default)]
pub(super) struct Tabs(Mutex<Known>);

#[derive(Debug, Default)]
struct Known {
    latest: HashMap<(String, &'static str), Latest>,
    requests: u64,
}

#[derive(Debug)]
struct Latest {
    number: u64,
    stop: Arc<AtomicBool>,
    /// Count of all requests at its arrival.
    came: u64,
}

/// A request in progress. Dropping it stops the work, since its answer is not needed any more.
#[derive(Debug)]
pub(super) struct Ticket(Arc<AtomicBool>);

impl Ticket {
    /// Set when the work is to stop.
    pub(super) fn stop(&self) -> &Arc<AtomicBool> {
        &self.0
    }

    pub(super) fn is_overtaken(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

impl Drop for Ticket {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

impl Tabs {
    fn known(&self) -> MutexGuard<'_, Known> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Supersedes earlier requests of the same tab about the same topic.
    pub(super) fn take(&self, turn: &Turn, topic: &'static str) -> Result<Ticket, Refusal> {
        if turn.tab.len() > LONGEST_NAME {
            return Err(Refusal::malformed("the name of the tab is too long"));
        }
        let mut known = self.known();
        known.requests += 1;
        let came = known.requests;
        let key = (turn.tab.clone(), topic);
        if let Some(earlier) = known.latest.get(&key) {
            if earlier.number > turn.number {
                return Err(Refusal::overtaken());
            }
            earlier.stop.store(true, Ordering::Relaxed);
        } else if known.latest.len() >= MOST {
            let oldest = known.latest.iter().min_by_key(|(_, latest)| latest.came);
            if let Some(oldest) = oldest.map(|(key, _)| key.clone()) {
                known.latest.remove(&oldest);
            }
        }
        let stop = Arc::<AtomicBool>::default();
        known.latest.insert(key, Latest { number: turn.number, stop: Arc::clone(&stop), came });
        Ok(Ticket(stop))
    }

    pub(super) fn stop_all(&self) {
        self.known().latest.values().for_each(|latest| latest.stop.store(true, Ordering::Relaxed));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turn(tab: &str, number: u64) -> Turn {
        Turn { tab: tab.into(), number }
    }

    #[test]
    fn a_newer_request_of_the_same_tab_and_topic_stops_the_older() {
        let tabs = Tabs::default();
        let first = tabs.take(&turn("a", 1), "plane").unwrap();
        let other_tab = tabs.take(&turn("b", 1), "plane").unwrap();
        let other_topic = tabs.take(&turn("a", 1), "point").unwrap();
        assert!(!first.is_overtaken());
        let second = tabs.take(&turn("a", 2), "plane").unwrap();
        assert!(first.is_overtaken() && !second.is_overtaken());
        assert!(!other_tab.is_overtaken() && !other_topic.is_overtaken());
        assert_eq!(tabs.take(&turn("a", 1), "plane").unwrap_err(), Refusal::overtaken());
    }

    #[test]
    fn few_tabs_are_remembered() {
        let tabs = Tabs::default();
        for number in 0..10 * MOST {
            tabs.take(&turn(&number.to_string(), 0), "plane").unwrap();
        }
        assert_eq!(tabs.known().latest.len(), MOST);
        assert!(tabs.take(&turn(&"x".repeat(LONGEST_NAME + 1), 0), "plane").is_err());
    }
}
