//! Hub that computes the bits of a test vector.

use fos_embedded::hub::{Hub, HubError};
use fos_embedded::raw::Scales;
use fos_fit::model::UnitModel;

/// Hub large enough for every model.
pub(super) type HostHub = Hub<32, 512, 4096>;

/// Creates a hub with `model`, for a sensor with these scales.
pub(crate) fn loaded(model: &UnitModel, scales: Scales) -> Result<HostHub, HubError> {
    let mut hub = HostHub::new(scales);
    model.with::<f32, _>(|model| hub.load_model(model))?;
    Ok(hub)
}
