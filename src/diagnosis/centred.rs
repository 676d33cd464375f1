//! Laws of amplitude and temperature about the middle of a table.

use super::data::Data;
use crate::model::{Cause, Correction, REFERENCE_TEMPERATURE_C};
use crate::statistics::median;

/// A law that passes through the file's constant at no excitation, or at 20 °C, as one about the
/// table's median: a pose that states no level or temperature is like those of the table.
pub(super) fn centred(correction: &mut Correction, data: &Data) {
    let conditions = data.rows.iter().map(|row| row.conditions);
    let (change, reference, at, typical) = match correction.cause {
        Cause::AmplitudeDependence => {
            let levels = conditions.filter_map(|c| c.amplitude_nm).collect();
            ("change_per_nm", "reference_nm", 0.0, median(levels))
        }
        Cause::TemperatureDrift => {
            let temperatures = conditions.filter_map(|c| c.temperature_c).collect();
            ("change_per_k", "reference_c", REFERENCE_TEMPERATURE_C, median(temperatures))
        }
        // No other law depends on conditions ([`Cause::changes`]).
        _ => return,
    };
    let (Some(change), Some(typical)) = (correction.value(change), typical) else { return };
    if correction.value(reference).is_some() {
        return;
    }
    let factor = correction.value("factor").unwrap_or(1.0) + change * (typical - at);
    correction.parameters.retain(|(name, _)| name != "factor");
    correction.parameters.push(("factor".to_owned(), factor));
    correction.parameters.push((reference.to_owned(), typical));
}
