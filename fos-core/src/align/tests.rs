use super::*;

#[test]
#[cfg(target_pointer_width = "64")]
fn it_is_as_large_as_its_documentation_says() {
    assert_eq!(size_of::<Aligner<f32, 1, 1, 32>>(), 1928);
}
