//! Mutations of text files, for tests that reading them gives a result or an error, and never a fault. Unit tests of several
//! packages below `src/` share this file.
//!
//! `QUADRATURA_MUTATIONS=1000000 cargo test --release -p quadratura-io --lib mutated`, for example, reads as many of each format.

use quadratura_base::scene::synthetic::Rng;

/// Returns the number of mutations: `usual`, or what the environment says.
pub fn mutations(usual: u32) -> u32 {
    std::env::var("QUADRATURA_MUTATIONS").ok().and_then(|count| count.parse().ok()).unwrap_or(usual)
}

/// Returns a text after one to four changes: bytes, cuts, repeats, splices, exchanged words, numbers, and these words.
#[allow(dead_code)]
pub fn mutated(text: &str, words: &[&str], rng: &mut Rng) -> Vec<u8> {
    const NUMBERS: [&str; 9] = ["nan", "inf", "1e999", "-1", "99999999999", "0", "1e-320", "1e15", "-0.5"];
    let mut bytes = text.as_bytes().to_vec();
    for _ in 0..rng.whole(1, 4) {
        let place = |rng: &mut Rng, bytes: &[u8]| rng.whole(0, bytes.len() as u32 - 1) as usize;
        let at = place(rng, &bytes);
        let end = (at + rng.whole(0, 30) as usize).min(bytes.len());
        match rng.whole(0, 7) {
            0 => bytes[at] = rng.bits() as u8,
            1 => drop(bytes.drain(at..end)),
            2 => drop(bytes.splice(at..at, bytes[at..end].to_vec())),
            3 if rng.chance(0.3) => bytes.truncate(at.max(1)),
            4 => bytes[at] = b"0123456789.-+eE \n{}#()^*/"[rng.whole(0, 24) as usize],
            5 => {
                let other = place(rng, &bytes);
                let piece = bytes[at..end].to_vec();
                drop(bytes.splice(other..other, piece));
            }
            6 => exchange(&mut bytes, at, end),
            which => {
                let words = if which == 3 { &NUMBERS } else { words };
                let word = words[rng.whole(0, words.len() as u32 - 1) as usize];
                let from = bytes[..at].iter().rposition(u8::is_ascii_whitespace).map_or(0, |i| i + 1);
                let to = if which == 3 { end_of_word(&bytes, from) } else { from };
                drop(bytes.splice(from..to, format!("{word} ").into_bytes()));
            }
        }
        if bytes.is_empty() {
            bytes.push(b' ');
        }
    }
    bytes
}

fn end_of_word(bytes: &[u8], from: usize) -> usize {
    bytes[from..].iter().position(u8::is_ascii_whitespace).map_or(bytes.len(), |length| from + length)
}

/// Exchanges the first two words between two places.
fn exchange(bytes: &mut Vec<u8>, at: usize, end: usize) {
    let part = String::from_utf8_lossy(&bytes[at..end]).into_owned();
    let mut words: Vec<&str> = part.split(' ').collect();
    if words.len() > 1 {
        words.swap(0, 1);
    }
    drop(bytes.splice(at..end, words.join(" ").into_bytes()));
}
