//! Curves of many points, drawn by those that the eye can tell from a straight line.

/// What is left out lies so near to the line through its neighbours, px.
const TOLERANCE_PX: f64 = 0.15;

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
    (0..points.len()).filter(|&i| kept[i]).collect()
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
        let odd = [(0.0, 1.0), (0.5, f64::NAN), (1.0, 1.0)];
        assert_eq!(thinned(&odd), [0, 1, 2]);
    }
}
