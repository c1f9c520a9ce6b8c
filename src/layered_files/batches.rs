//! Splits work on large items into batches of limited size, in order.

/// Bytes of pixels per batch: enough to keep all threads busy, and little compared with the photo.
const BATCH: u64 = 64 << 20;

/// Splits `items` into runs of neighbours of about 64 MiB (`BATCH`) each; a larger item forms a batch of its
/// own.
pub fn batches<T>(items: &[T], bytes_of: impl Fn(&T) -> u64) -> Vec<&[T]> {
    let mut batches = Vec::new();
    let (mut start, mut bytes) = (0, 0);
    for (index, item) in items.iter().enumerate() {
        let weight = bytes_of(item);
        if bytes + weight > BATCH && index > start {
            batches.push(&items[start..index]);
            (start, bytes) = (index, 0);
        }
        bytes += weight;
    }
    if start < items.len() {
        batches.push(&items[start..]);
    }
    batches
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_item_is_in_one_batch_and_none_is_too_heavy() {
        let items = [1, 2, BATCH, 3, BATCH + 1, 4, 5];
        let found = batches(&items, |bytes| *bytes);
        assert_eq!(found, [&items[..2], &items[2..3], &items[3..4], &items[4..5], &items[5..]]);
        assert!(batches(&[0u64; 0], |bytes| *bytes).is_empty());
    }
}
