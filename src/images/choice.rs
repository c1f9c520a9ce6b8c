//! Which photos a view needs: the *controller* of the published system (Gortler, He & Cohen 1997, section 2), with shares of the
//! view instead of angles and distances.

use quadratura_base::scene::PhotoId;
use quadratura_projection::exposure::Shares;

/// The least share of a view from which on a photo is used for it.
const LEAST_SHARE: f64 = 1e-4;

/// Returns the photos with the largest shares of a view, `most` at most, the largest first; of equal ones the first of the
/// site.
pub fn best_photos(shares: &Shares, most: usize) -> Vec<PhotoId> {
    let mut photos: Vec<(f64, PhotoId)> =
        shares.of_photo.iter().copied().zip(PhotoId::all(shares.of_photo.len())).collect();
    photos.retain(|(share, _)| *share > LEAST_SHARE);
    photos.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    photos.into_iter().take(most).map(|(_, photo)| photo).collect()
}

/// How much photos count that show something of a view only where others are left out: enough to be chosen, too little to
/// change a choice.
const BESIDE: f64 = 0.01;

/// Adds photos to the shares of a view that has fewer than it could use, as from a photo's own camera, which has all: those
/// that show most of it without the best ones. They show what appears when the view moves.
pub fn add_beside(shares: &mut Shares, without_best: &Shares) {
    let others = shares.of_photo.iter_mut().zip(&without_best.of_photo);
    others.filter(|(share, _)| **share <= LEAST_SHARE).for_each(|(share, other)| *share = BESIDE * other);
}

/// The factor by which the shares of other photos have to add up to more than those of the present ones before the image is
/// made of them: 10 % more. Without it, a view between two sets would change from one to the other with each movement.
const CLEARLY_MORE: f64 = 1.1;

/// Returns the photos that a view wants instead of the `present` ones; `None` where these are good enough, or where no photo
/// shows anything of the view.
pub fn better_photos(shares: &Shares, present: &[PhotoId], most: usize) -> Option<Vec<PhotoId>> {
    let sum = |photos: &[PhotoId]| -> f64 {
        photos.iter().filter_map(|photo| shares.of_photo.get(photo.index())).sum()
    };
    let best = best_photos(shares, most);
    (!best.is_empty() && sum(&best) > CLEARLY_MORE * sum(present)).then_some(best)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(shares: [f64; 4]) -> Shares {
        Shares { of_photo: shares.to_vec(), of_common: 0.0, takes_part: vec![true; 4] }
    }

    #[test]
    fn a_photo_s_own_camera_uses_those_beside_it_and_they_change_no_choice() {
        let mut shares = of([0.0, 1.0, 0.0, 0.0]);
        add_beside(&mut shares, &of([0.3, 0.0, 0.005, 0.6]));
        let best: Vec<u32> = best_photos(&shares, 9).iter().map(|photo| photo.0).collect();
        assert_eq!(best, [1, 3, 0], "half a percent is nothing");
        assert_eq!(better_photos(&shares, &[PhotoId(1), PhotoId(2)], 3), None);
    }

    #[test]
    fn other_photos_are_wanted_only_where_they_show_clearly_more() {
        let better = |shares: [f64; 4], present: &[u32]| {
            let present: Vec<PhotoId> = present.iter().map(|id| PhotoId(*id)).collect();
            let wanted = better_photos(&of(shares), &present, 2)?;
            Some(wanted.iter().map(|photo| photo.0).collect::<Vec<_>>())
        };
        assert_eq!(better([0.3, 0.2, 0.1, 0.0], &[]), Some(vec![0, 1]), "nothing is there");
        assert_eq!(better([0.3, 0.2, 0.1, 0.0], &[1, 0]), None, "the same photos in another order");
        // 0.50 against 0.46: less than 10 % more.
        assert_eq!(better([0.26, 0.24, 0.2, 0.0], &[0, 2]), None);
        // 0.50 against 0.45: more.
        assert_eq!(better([0.26, 0.24, 0.19, 0.0], &[0, 2]), Some(vec![0, 1]));
        assert_eq!(better([0.0; 4], &[0, 2]), None, "no photo shows anything of the view");
        assert_eq!(better([0.3, 0.0, 0.0, 0.0], &[1]), Some(vec![0]));
    }

    #[test]
    fn a_view_that_goes_to_and_fro_between_two_sets_does_not_change_them() {
        let (mut present, mut changes) = (vec![PhotoId(0), PhotoId(1)], 0);
        // On the middle of the way each set is a little better by turns: 0.418 against 0.382 is less than 10 % more.
        let asides = |count: usize| [0.009, -0.009].into_iter().cycle().take(count);
        for aside in asides(40).chain([0.05]).chain(asides(40)) {
            let shares = of([0.2 - aside, 0.2 - aside, 0.2 + aside, 0.2 + aside]);
            if let Some(wanted) = better_photos(&shares, &present, 2) {
                (present, changes) = (wanted, changes + 1);
            }
        }
        assert_eq!((present, changes), (vec![PhotoId(2), PhotoId(3)], 1), "the one large step");
    }

    #[test]
    fn the_photos_with_the_largest_shares_come_first_and_those_without_are_left_out() {
        let shares = Shares {
            of_photo: vec![0.1, 0.0, 0.3, 0.3, 0.00005, 0.2],
            of_common: 0.0,
            takes_part: vec![true; 6],
        };
        let best = |most: usize| best_photos(&shares, most).iter().map(|photo| photo.0).collect::<Vec<_>>();
        assert_eq!(best(3), [2, 3, 5]);
        assert_eq!(best(9), [2, 3, 5, 0]);
    }
}
