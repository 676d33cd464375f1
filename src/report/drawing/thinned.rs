//! Curves of many points, drawn by those that the eye can tell from a straight line.

/// What is left out lies so near to the line through its neighbours, px.
const TOLERANCE_PX: f64 = 0.15;

/// A curve with more points than two in each column of this width is drawn by the lowest and the
/// highest of each: what goes up and down within is seen as filled.
const COLUMN_PX: f64 = 6.0;

/// The points of a curve on the canvas that count (Douglas & Peucker, The Canadian Cartographer
/// 10, 1973, with distances along y), by their places.
pub(super) fn thinned(points: &[(f64, f64)]) -> Vec<usize> {
    let Some(last) = points.len().checked_sub(1) else { return Vec::new() };
    let mut kept = vec![false; points.len()];
    (kept[0], kept[last]) = (true, true);
    let mut open = vec![(0, last)];
    while let Some((from, to)) = open.pop() {
        let ((x0, y0), (x1, y1)) = (points[from], points[to]);
        let slope = if x1 > x0 { (y1 - y0) / (x1 - x0) } else { 0.0 };
        let apart = |i: usize| (points[i].1 - (y0 + slope * (points[i].0 - x0))).abs();
        let farthest = (from + 1..to).max_by(|&a, &b| apart(a).total_cmp(&apart(b)));
        // What is no number stays, so that the curve breaks there.
        if let Some(at) = farthest.filter(|&at| apart(at).is_nan() || apart(at) > TOLERANCE_PX) {
            kept[at] = true;
            open.extend([(from, at), (at, to)]);
        }
    }
    let kept: Vec<usize> = (0..points.len()).filter(|&i| kept[i]).collect();
    let columns = ((points[last].0 - points[0].0) / COLUMN_PX).ceil().max(1.0);
    if kept.len() as f64 > 2.0 * columns { ends_of_columns(points, &kept) } else { kept }
}

/// Of each column the lowest and the highest point, and both ends of the curve.
fn ends_of_columns(points: &[(f64, f64)], kept: &[usize]) -> Vec<usize> {
    let column = |i: &usize| ((points[*i].0 - points[kept[0]].0) / COLUMN_PX).floor();
    let mut all: Vec<usize> = kept.first().copied().into_iter().collect();
    for of_column in kept.chunk_by(|a, b| column(a) == column(b)) {
        let by_height = |a: &&usize, b: &&usize| points[**a].1.total_cmp(&points[**b].1);
        let ends = [of_column.iter().min_by(by_height), of_column.iter().max_by(by_height)];
        let mut own: Vec<usize> = ends.into_iter().flatten().copied().collect();
        own.sort_unstable();
        all.extend(own);
    }
    all.extend(kept.last());
    all.dedup();
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_out_lies_on_the_line() {
        let wave = (0..20_000).map(|i| f64::from(i) / 30.0).map(|x| (x, 200.0 * (x / 50.0).sin()));
        let wave: Vec<(f64, f64)> = wave.collect();
        let thin = thinned(&wave);
        assert!(thin.len() < 400, "{}", thin.len());
        for pair in thin.windows(2) {
            let ((x0, y0), (x1, y1)) = (wave[pair[0]], wave[pair[1]]);
            for (x, y) in &wave[pair[0]..pair[1]] {
                let on_line = y0 + (y1 - y0) * (x - x0) / (x1 - x0);
                assert!((y - on_line).abs() <= TOLERANCE_PX, "{x}");
            }
        }
        // Two hundred teeth in 100 px: their ends stay, and few points.
        let teeth: Vec<(f64, f64)> =
            (0..=4000).map(|i| (0.025 * f64::from(i), f64::from(i % 20) * 5.0)).collect();
        let thin = thinned(&teeth);
        assert!(thin.len() <= 2 * 19, "{}", thin.len());
        assert!(thin.windows(2).all(|pair| pair[0] < pair[1]), "{thin:?}");
        let heights = || thin.iter().map(|&i| teeth[i].1);
        assert_eq!((heights().fold(9.0, f64::min), heights().fold(0.0, f64::max)), (0.0, 95.0));
        let odd = [(0.0, 1.0), (0.5, f64::NAN), (1.0, 1.0)];
        assert_eq!(thinned(&odd), [0, 1, 2]);
    }
}
