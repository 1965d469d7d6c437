//! The image of a unit through C, from the image of its part and its record, and all rejections.

use core::ptr::{null, null_mut};

use crate::models::numbered;
use fos_core::image::{Image, encode_unit};
use fos_embedded::c_api::*;

/// Calls the function with a buffer of `room` bytes; returns the status and the first `used` bytes.
fn made(part: &[u8], record: &[u8], room: usize) -> (fos_status, Vec<u8>) {
    let (mut buffer, mut used) = (vec![0xaa_u8; room], 77);
    let status = unsafe {
        fos_image_for_unit(
            part.as_ptr(),
            part.len(),
            record.as_ptr(),
            record.len(),
            buffer.as_mut_ptr(),
            room,
            &raw mut used,
        )
    };
    buffer.truncate(used);
    (status, buffer)
}

#[test]
fn part_and_record_give_a_valid_image() {
    let (part, other) = (numbered(1, 300), numbered(2, 300));
    let image = Image::parse(&part).expect("an image");
    let values: Vec<f32> = image
        .axes()
        .flat_map(|axis| std::iter::once(0.25).chain(axis.physical.map(|term| term.coefficient + 1.0)))
        .collect();
    let mut buffer = [0; 512];
    let record = encode_unit(&part, "unit 7", values.iter().copied(), &mut buffer).expect("a record");

    let (status, unit) = made(&part, record, part.len());
    assert_eq!((status, unit.len()), (fos_status::Ok, part.len()));
    let read = Image::parse(&unit).expect("an image");
    assert!(read.axes().all(|axis| axis.parameters.offset == 0.25));

    assert_eq!(made(&part, record, part.len() - 1), (fos_status::NoRoom, vec![]));
    assert_eq!(made(&other, record, other.len()), (fos_status::OtherPart, vec![]));
    assert_eq!(made(&part, &part, part.len()), (fos_status::NotAnImage, vec![]));
    assert_eq!(made(record, record, part.len()), (fos_status::NotAnImage, vec![]));
    for place in 0..record.len() {
        let mut damaged = record.to_vec();
        damaged[place] ^= 1;
        let (status, left) = made(&part, &damaged, part.len());
        assert!(left.is_empty());
        let expected = match place {
            0..4 => fos_status::NotAnImage,
            4..6 => fos_status::OtherVersion,
            _ => fos_status::Damaged,
        };
        assert_eq!(status, expected, "byte {place}");
    }
    for length in 0..record.len() {
        let (status, _) = made(&part, &record[..length], part.len());
        assert!(matches!(status, fos_status::Truncated | fos_status::Damaged), "{length}: {status:?}");
    }
}

#[test]
fn rejects_invalid_pointers() {
    let part = numbered(1, 300);
    let mut room = vec![0_u8; part.len()];
    let mut used = 77_usize;
    let call = |part: *const u8, record: *const u8, room: *mut u8, length: usize, used: *mut usize| unsafe {
        fos_image_for_unit(part, length, record, length, room, length, used)
    };
    let (bytes, length, to) = (part.as_ptr(), part.len(), room.as_mut_ptr());
    for (part, record, room) in [(null(), bytes, to), (bytes, null(), to), (bytes, bytes, null_mut())] {
        used = 77;
        assert_eq!(call(part, record, room, length, &raw mut used), fos_status::Null);
        assert_eq!(used, 0);
    }
    assert_eq!(call(bytes, bytes, to, usize::MAX, &raw mut used), fos_status::Argument);
    assert_eq!(call(bytes, bytes, to, length, null_mut()), fos_status::Null);
    let odd = (&raw mut used).cast::<u8>().wrapping_add(1).cast();
    assert_eq!(call(bytes, bytes, to, length, odd), fos_status::Misaligned);
}
