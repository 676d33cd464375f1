//! Roll, pitch and yaw → a frame: one meaning of the three angles in every file.

use nalgebra::{Isometry3, Translation3, UnitQuaternion};

/// The frame at `xyz_m`, turned about fixed axes as the URDF standard says: R = Rz(yaw) · Ry(pitch)
/// · Rx(roll).
pub(super) fn frame(xyz_m: [f64; 3], rpy_rad: [f64; 3]) -> Isometry3<f64> {
    let [x, y, z] = xyz_m;
    let [roll, pitch, yaw] = rpy_rad;
    Isometry3::from_parts(
        Translation3::new(x, y, z),
        UnitQuaternion::from_euler_angles(roll, pitch, yaw),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Matrix3;

    #[test]
    fn yaw_comes_last_and_about_the_axes_that_stay() {
        let angles = [0.3_f64, -0.7, 2.1];
        let ([sr, sp, sy], [cr, cp, cy]) = (angles.map(f64::sin), angles.map(f64::cos));
        let about_x = Matrix3::new(1.0, 0.0, 0.0, 0.0, cr, -sr, 0.0, sr, cr);
        let about_y = Matrix3::new(cp, 0.0, sp, 0.0, 1.0, 0.0, -sp, 0.0, cp);
        let about_z = Matrix3::new(cy, -sy, 0.0, sy, cy, 0.0, 0.0, 0.0, 1.0);
        let found = frame([1.0, 2.0, 3.0], angles);
        let off = found.rotation.to_rotation_matrix().matrix() - about_z * about_y * about_x;
        assert!(off.norm() < 1e-15, "{off}");
        assert_eq!(found.translation.vector, nalgebra::Vector3::new(1.0, 2.0, 3.0));
    }
}
