//! Several layered depth images that are shown together, and the choice of the cameras of a set that covers a site.

use super::layout::Ldi;

/// Layered depth images that are shown together. There is at least one.
#[derive(Debug, Clone, PartialEq)]
pub struct LdiSet {
    /// How the images belong together.
    pub arrangement: Arrangement,
    /// The images; those of a cube in the order of [`super::cube::FACE_NAMES`].
    pub images: Vec<Ldi>,
}

impl From<Ldi> for LdiSet {
    fn from(ldi: Ldi) -> Self {
        Self { arrangement: Arrangement::Single, images: vec![ldi] }
    }
}

/// How layered depth images belong together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Arrangement {
    /// One alone.
    Single,
    /// The six faces of a cube around one centre ([`super::cube`]).
    Cube,
    /// Any number with cameras of their own, which are drawn into the same sums.
    Set,
}

impl Arrangement {
    /// Those of more than one image.
    pub const OF_SEVERAL: [Self; 2] = [Self::Cube, Self::Set];

    /// Returns its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Single => "single",
            Self::Cube => "cube",
            Self::Set => "set",
        }
    }
}

/// A camera that was chosen for a set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Chosen {
    /// Its index among the candidates.
    pub candidate: usize,
    /// The points that it covers.
    pub covers: usize,
    /// Those of them that none of the cameras chosen before it covers.
    pub adds: usize,
}

/// Chooses the candidates of a set: each time the one that covers most points that are not yet covered, of equal ones the first
/// by name, until the covered share is at least `enough` (0 to 1), there are `most`, or none adds a point. `covers` has one row
/// for each candidate, and in each row one entry for each point; `names` has the candidates' names.
pub fn chosen_for_set(covers: &[Vec<bool>], names: &[&str], most: usize, enough: f64) -> Vec<Chosen> {
    let points = covers.first().map_or(0, Vec::len);
    let mut covered = vec![false; points];
    let mut chosen: Vec<Chosen> = Vec::new();
    let mut count = 0;
    while chosen.len() < most && (count as f64) < enough * points as f64 {
        let adds = |row: &[bool]| {
            row.iter().zip(&covered).filter(|(covers, covered)| **covers && !**covered).count()
        };
        let rest = (0..covers.len()).filter(|index| chosen.iter().all(|other| other.candidate != *index));
        let best = rest
            .map(|index| (adds(&covers[index]), index))
            .max_by(|(a, at_a), (b, at_b)| a.cmp(b).then_with(|| names[*at_b].cmp(names[*at_a])));
        let Some((adds, candidate)) = best.filter(|(adds, _)| *adds > 0) else { break };
        covered.iter_mut().zip(&covers[candidate]).for_each(|(covered, covers)| *covered |= covers);
        count += adds;
        let covers = covers[candidate].iter().filter(|covers| **covers).count();
        chosen.push(Chosen { candidate, covers, adds });
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::Rng;

    /// Returns rows of points that are covered, written as stars.
    fn rows(rows: &[&str]) -> Vec<Vec<bool>> {
        rows.iter().map(|row| row.bytes().map(|byte| byte == b'*').collect()).collect()
    }

    fn indices(chosen: &[Chosen]) -> Vec<usize> {
        chosen.iter().map(|one| one.candidate).collect()
    }

    #[test]
    fn the_camera_that_covers_most_of_the_rest_is_next_and_names_decide_among_equal_ones() {
        let covers = rows(&["***.......", ".****.....", "......***.", ".......***", "*........."]);
        let names = ["e", "d", "c", "b", "a"];
        let chosen = chosen_for_set(&covers, &names, 9, 1.0);
        assert_eq!(indices(&chosen), [1, 3, 4, 2], "b before c, a before e");
        let counts: Vec<_> = chosen.iter().map(|one| (one.covers, one.adds)).collect();
        assert_eq!(counts, [(4, 4), (3, 3), (1, 1), (3, 1)]);
    }

    #[test]
    fn the_choice_ends_at_the_share_at_the_number_and_where_nothing_is_added() {
        let covers = rows(&["*****.....", ".....***..", "........*.", "*****....."]);
        let names = ["a", "b", "c", "d"];
        let chosen = |most, enough| indices(&chosen_for_set(&covers, &names, most, enough));
        assert_eq!(chosen(9, 0.5), [0]);
        assert_eq!(chosen(9, 0.51), [0, 1]);
        assert_eq!(chosen(1, 1.0), [0]);
        assert_eq!(chosen(9, 1.0), [0, 1, 2], "d adds nothing, and one point is covered by nobody");
        assert_eq!(chosen_for_set(&[], &[], 9, 1.0), []);
        assert_eq!(chosen_for_set(&rows(&["", ""]), &["a", "b"], 9, 1.0), []);
    }

    #[test]
    fn each_chosen_camera_adds_no_more_than_the_one_before_it() {
        let mut rng = Rng::new(3);
        for _ in 0..20 {
            let covers: Vec<Vec<bool>> =
                (0..12).map(|_| (0..200).map(|_| rng.chance(0.2)).collect()).collect();
            let names: Vec<String> = (0..12).map(|i| format!("{i:02}")).collect();
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            let chosen = chosen_for_set(&covers, &names, 12, 0.99);
            assert!(chosen.windows(2).all(|pair| pair[0].adds >= pair[1].adds), "{chosen:?}");
            let coverable = (0..200).filter(|&i| covers.iter().any(|row| row[i])).count();
            let covered: usize = chosen.iter().map(|one| one.adds).sum();
            assert!(covered >= coverable.min(198), "{covered} of {coverable}");
        }
    }
}
