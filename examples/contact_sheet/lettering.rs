//! Capitals drawn with a pen: each letter is a few straight strokes on a grid of 4 x 6.

use quadratura::testing::editing::exploded::premultiplied::{Ink, PremultipliedPicture};

/// Strokes are separated by spaces; a stroke is a chain of points, each a column 0..4 and a row 0..6.
const LETTERS: &[(char, &str)] = &[
    ('A', "062046 1434"),
    ('B', "06003041423303 3344453606"),
    ('C', "4130100105163645"),
    ('D', "06003041453606"),
    ('E', "40000646 0333"),
    ('F', "400006 0333"),
    ('G', "41301001051636454323"),
    ('H', "0006 4046 0343"),
    ('I', "2026"),
    ('J', "404536160504"),
    ('K', "0006 4003 0346"),
    ('L', "000646"),
    ('M', "0600234046"),
    ('N', "06004640"),
    ('O', "100105163645413010"),
    ('P', "06003041423303"),
    ('Q', "100105163645413010 3547"),
    ('R', "06003041423303 2346"),
    ('S', "413010010213334445361605"),
    ('T', "0040 2026"),
    ('U', "000516364540"),
    ('V', "002640"),
    ('W', "0016233640"),
    ('X', "0046 4006"),
    ('Y', "002340 2326"),
    ('Z', "00400646"),
    ('0', "100105163645413010"),
    ('1', "112026"),
    ('2', "01103041420646"),
    ('3', "01103041423313 334445361605"),
    ('4', "36300444"),
    ('5', "400003334445361605"),
    ('6', "413010010516364544331303"),
    ('7', "004016"),
    ('8', "100102133342413010 1304051636454433"),
    ('9', "051636454130100102133343"),
    ('.', "2526"),
    ('-', "0343"),
    ('+', "2125 0343"),
    ('_', "0646"),
    ('[', "30101636"),
    (']', "10303616"),
    ('/', "0640"),
    (',', "2517"),
    (':', "2122 2526"),
    ('%', "0640 0111 3646"),
];

/// Width of a letter with the space behind it, relative to its height.
const PITCH: f64 = 0.92;

/// Draws `text`, in capitals, with the top-left corner of its first letter at `at`.
pub fn write(canvas: &mut PremultipliedPicture, text: &str, at: [f64; 2], height: f64, ink: Ink) {
    for (i, letter) in text.to_uppercase().chars().enumerate() {
        let strokes = LETTERS.iter().find(|(c, _)| *c == letter).map_or("", |(_, strokes)| strokes);
        let x = at[0] + i as f64 * height * PITCH;
        for stroke in strokes.split(' ') {
            let points: Vec<[f64; 2]> =
                stroke.as_bytes().chunks(2).map(|p| point(p, x, at[1], height)).collect();
            for pair in points.windows(2) {
                canvas.line(pair[0], pair[1], (height / 7.0).max(1.2), ink);
            }
        }
    }
}

/// The place of a point of the grid; the grid is narrower than it is high.
fn point(digits: &[u8], x: f64, y: f64, height: f64) -> [f64; 2] {
    let number = |i: usize| f64::from(digits.get(i).map_or(0, |d| d - b'0'));
    [x + number(0) / 6.0 * height, y + number(1) / 6.0 * height]
}

/// `text`, shortened until it is at most `room` pixels wide.
pub fn fitted(text: &str, height: f64, room: f64) -> String {
    let letters = (room / (height * PITCH)).floor().max(1.0) as usize;
    if text.chars().count() <= letters {
        return text.into();
    }
    let kept: String = text.chars().take(letters.saturating_sub(2)).collect();
    format!("{kept}..")
}
