//! Small dense linear algebra: eigenvectors of symmetric matrices, and systems of equations.

/// Returns the eigenvalues of a symmetric matrix with their unit eigenvectors, the smallest value first, by Jacobi's
/// rotations (Golub and Van Loan, *Matrix Computations*, section 8.5).
pub fn eigen<const N: usize>(mut a: [[f64; N]; N]) -> [(f64, [f64; N]); N] {
    let mut vectors: [[f64; N]; N] =
        std::array::from_fn(|i| std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 }));
    // Convergence is quadratic: a matrix of four rows is done after some five sweeps.
    for _ in 0..30 {
        let off: f64 = (0..N).flat_map(|i| (0..i).map(move |j| (i, j))).map(|(i, j)| a[i][j].powi(2)).sum();
        if off == 0.0 {
            break;
        }
        for p in 0..N {
            for q in p + 1..N {
                rotate(&mut a, &mut vectors, p, q);
            }
        }
    }
    let mut all: [(f64, [f64; N]); N] =
        std::array::from_fn(|i| (a[i][i], std::array::from_fn(|row| vectors[row][i])));
    all.sort_by(|x, y| x.0.total_cmp(&y.0));
    all
}

/// Turns rows and columns p and q so that a[p][q] vanishes.
fn rotate<const N: usize>(a: &mut [[f64; N]; N], vectors: &mut [[f64; N]; N], p: usize, q: usize) {
    if a[p][q] == 0.0 {
        return;
    }
    let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
    let t = theta.signum() / (theta.abs() + theta.hypot(1.0));
    let c = 1.0 / t.hypot(1.0);
    let s = t * c;
    for row in a.iter_mut() {
        (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
    }
    let [row_p, row_q] = a.get_disjoint_mut([p, q]).expect("two rows of the matrix");
    for (x, y) in row_p.iter_mut().zip(row_q) {
        (*x, *y) = (c * *x - s * *y, s * *x + c * *y);
    }
    for row in vectors.iter_mut() {
        (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
    }
}

/// Solves a x = b for a symmetric positive definite matrix; `None` where it is not.
pub fn solve<const N: usize>(mut a: [[f64; N]; N], mut b: [f64; N]) -> Option<[f64; N]> {
    for i in 0..N {
        for j in 0..=i {
            let sum: f64 = (0..j).map(|k| a[i][k] * a[j][k]).sum();
            let rest = a[i][j] - sum;
            if i == j {
                if rest.is_nan() || rest <= 0.0 {
                    return None;
                }
                a[i][i] = rest.sqrt();
            } else {
                a[i][j] = rest / a[j][j];
            }
        }
    }
    for i in 0..N {
        let sum: f64 = (0..i).map(|k| a[i][k] * b[k]).sum();
        b[i] = (b[i] - sum) / a[i][i];
    }
    for i in (0..N).rev() {
        let sum: f64 = (i + 1..N).map(|k| a[k][i] * b[k]).sum();
        b[i] = (b[i] - sum) / a[i][i];
    }
    b.iter().all(|x| x.is_finite()).then_some(b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eigenvectors_are_stretched_by_their_eigenvalues() {
        let a = [[4.0, 1.0, -2.0], [1.0, 2.0, 0.0], [-2.0, 0.0, 3.0]];
        let found = eigen(a);
        assert!(found[0].0 < found[1].0 && found[1].0 < found[2].0);
        for (value, vector) in found {
            for (i, row) in a.iter().enumerate() {
                let product: f64 = row.iter().zip(&vector).map(|(x, y)| x * y).sum();
                assert!((product - value * vector[i]).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn a_definite_system_is_solved_and_an_indefinite_one_is_refused() {
        let x = solve([[4.0, 1.0], [1.0, 3.0]], [6.0, 7.0]).unwrap();
        assert!((x[0] - 1.0).abs() < 1e-12 && (x[1] - 2.0).abs() < 1e-12);
        assert_eq!(solve([[1.0, 2.0], [2.0, 1.0]], [1.0, 1.0]), None);
    }
}
