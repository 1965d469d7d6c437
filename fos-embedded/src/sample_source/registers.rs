//! Registers of one byte, with the values of a set-up.

/// Register and value.
pub(super) type Setting = (u8, u8);

/// Returns true if the registers read from `first` on have the values of the set-up; registers outside are not checked.
pub(super) fn are_set(settings: &[Setting], first: u8, read: &[u8]) -> bool {
    settings.iter().all(|(register, written)| {
        let place = register.checked_sub(first);
        place.and_then(|place| read.get(usize::from(place))).is_none_or(|read| read == written)
    })
}
