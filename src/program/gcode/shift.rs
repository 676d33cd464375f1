//! Shifted zeros of G-code: G52, G92, and work offsets that the program itself sets (G10).

use std::collections::HashMap;

use nalgebra::Vector3;

/// G54, in tenths: what holds where the program chooses no offset.
const FIRST: i64 = 540;

/// Shifts below this are rounding.
const ROUNDING_MM: f64 = 1e-9;

/// Where the program's zero is in the job's work object, which stands for the work offset under
/// which the path starts. mm.
#[derive(Debug, Clone)]
pub(super) struct Shift {
    local: Vector3<f64>,
    /// By axis, what it was when the axis last went to a place.
    local_at: Vector3<f64>,
    /// G92, with what G92.2 sets aside.
    axes: Vector3<f64>,
    aside: Vector3<f64>,
    /// Offsets of the machine as G10 L2 sets them, by code.
    origins: HashMap<i64, Vector3<f64>>,
    active: i64,
    /// Axes whose places count from an offset that held before, up to where the path starts.
    of_other: [bool; 3],
    /// The offset that is the job's work object.
    base: Option<i64>,
    /// Its origin when the path started.
    base_origin: Option<Vector3<f64>>,
    /// G10 L20: what the zero of the active offset has moved by.
    moved: Vector3<f64>,
}

impl Default for Shift {
    fn default() -> Self {
        Self {
            local: Vector3::zeros(),
            local_at: Vector3::zeros(),
            axes: Vector3::zeros(),
            aside: Vector3::zeros(),
            origins: HashMap::new(),
            active: FIRST,
            of_other: [false; 3],
            base: None,
            base_origin: None,
            moved: Vector3::zeros(),
        }
    }
}

impl Shift {
    pub(super) fn total(&self) -> Vector3<f64> {
        let origin = self.origins.get(&self.active);
        let offset = match (origin, self.base_origin) {
            (Some(origin), Some(base)) => origin - base,
            _ => Vector3::zeros(),
        };
        self.local + self.axes + self.moved + offset
    }

    /// The code of the work offset that holds, in tenths.
    pub(super) fn active(&self) -> i64 {
        self.active
    }

    pub(super) fn has_started(&self) -> bool {
        self.base.is_some()
    }

    /// The path has started: what holds now is the job's work object. Gives the axes whose places
    /// count from another offset.
    pub(super) fn start(&mut self) -> [bool; 3] {
        if self.base.is_none() {
            self.base = Some(self.active);
            self.base_origin = self.origins.get(&self.active).copied();
        }
        std::mem::take(&mut self.of_other)
    }

    /// Chooses a work offset; an error where the way from one to the other is not known. Before the
    /// path starts no way is lost: axes that are known by then are to be given anew.
    pub(super) fn choose(&mut self, code: i64, at: [Option<f64>; 3]) -> Result<(), ()> {
        if std::mem::replace(&mut self.active, code) == code {
            return Ok(());
        }
        let Some(base) = self.base else {
            for (is_of_other, at) in self.of_other.iter_mut().zip(at) {
                *is_of_other |= at.is_some();
            }
            return Ok(());
        };
        let is_known = self.origins.contains_key(&code) && self.base_origin.is_some();
        if base == code || is_known { Ok(()) } else { Err(()) }
    }

    /// TRANS puts the zero anew, axes that are not given where they were at first; ATRANS moves it.
    pub(super) fn translate(&mut self, axes: [Option<f64>; 3], adds: bool) {
        let by = Vector3::from(axes.map(|axis| axis.unwrap_or(0.0)));
        self.local = if adds { self.local + by } else { by };
    }

    /// An axis goes to a place, which counts from its zero.
    pub(super) fn goes_by_zero(&mut self, axis: usize) {
        self.local_at[axis] = self.local[axis];
        self.of_other[axis] = false;
    }

    /// Whether the zero of an axis was moved by TRANS or ATRANS since.
    pub(super) fn has_moved_zero(&self, axis: usize) -> bool {
        (self.local[axis] - self.local_at[axis]).abs() > ROUNDING_MM
    }

    /// G10 L2: the origin of an offset, axes as given.
    pub(super) fn set_origin(
        &mut self,
        offset: Option<i64>,
        axes: [Option<f64>; 3],
        relative: bool,
    ) -> Result<(), String> {
        let code = offset.unwrap_or(self.active);
        let before = self.origins.get(&code).copied();
        if self.base.is_some() && code == self.active && before.is_none() {
            return Err("moves the work offset that the job's work_object stands for".to_owned());
        }
        let mut origin = before.unwrap_or_default();
        for (axis, value) in axes.into_iter().enumerate() {
            if let Some(value) = value {
                origin[axis] = if relative { origin[axis] + value } else { value };
            }
        }
        self.origins.insert(code, origin);
        Ok(())
    }

    /// G92 or G10 L20: where the tool is has these coordinates from here on; what is not known of
    /// it is so from here on.
    pub(super) fn set_here(
        &mut self,
        at: &mut [Option<f64>; 3],
        axes: [Option<f64>; 3],
        is_of_offset: bool,
    ) {
        for (axis, value) in axes.into_iter().enumerate() {
            let Some(value) = value else { continue };
            let total = self.total()[axis];
            match &mut at[axis] {
                Some(at) => {
                    let moved = if is_of_offset { &mut self.moved } else { &mut self.axes };
                    moved[axis] += *at - total - value;
                }
                at => *at = Some(value + total),
            }
        }
    }

    pub(super) fn set_local(&mut self, axes: [Option<f64>; 3]) {
        for (axis, value) in axes.into_iter().enumerate() {
            if let Some(value) = value {
                self.local[axis] = value;
            }
        }
    }

    /// G52 and G92 both shift: controllers differ in what one makes of the other.
    pub(super) fn is_mixed(&self) -> bool {
        self.local != Vector3::zeros() && self.axes != Vector3::zeros()
    }

    /// G92.1 and G92.2.
    pub(super) fn reset(&mut self, keep: bool) {
        self.aside = if keep { self.axes } else { Vector3::zeros() };
        self.axes = Vector3::zeros();
    }

    /// G92.3.
    pub(super) fn restore(&mut self) {
        self.axes = self.aside;
    }
}
