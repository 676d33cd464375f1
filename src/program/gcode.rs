//! x
use super::{Settings, log::Log};
pub(super) fn read(_text: &str, _settings: &Settings, log: &mut Log) {
    log.fault(1, "x");
}
