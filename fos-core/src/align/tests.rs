use super::*;

#[test]
#[cfg(target_pointer_width = "64")]
fn has_the_documented_size() {
    assert_eq!(size_of::<Aligner<f32, 1, 1, 32>>(), 1928);
}
