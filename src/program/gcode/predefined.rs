//! LinuxCNC's own parameters that the program itself settles: where the tool is (`#<_x>`), units,
//! feed and speed. The others the job may assume.

/// What holds where a block begins.
#[derive(Debug, Default, Clone)]
pub(super) struct Predefined {
    /// In the program's coordinates and unit.
    pub(super) place: [Option<f64>; 3],
    /// The coordinates are turned or polar, in which the place is not worked out.
    pub(super) is_turned: bool,
    /// Whether lengths are in inches, where the program or the job says so.
    pub(super) inches: Option<bool>,
    pub(super) relative: bool,
    pub(super) feed: Option<f64>,
    pub(super) rpm: Option<f64>,
}

/// Which of them a parameter is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PredefinedName {
    Place(usize),
    Metric,
    Imperial,
    Absolute,
    Incremental,
    Feed,
    Rpm,
}

impl PredefinedName {
    /// By the name as the job writes it.
    pub(super) fn of(name: &str) -> Option<Self> {
        Some(match name {
            "_x" => Self::Place(0),
            "_y" => Self::Place(1),
            "_z" => Self::Place(2),
            "_metric" => Self::Metric,
            "_imperial" => Self::Imperial,
            "_absolute" => Self::Absolute,
            "_incremental" => Self::Incremental,
            "_feed" => Self::Feed,
            "_rpm" => Self::Rpm,
            _ => return None,
        })
    }
}

/// The name of LinuxCNC's for a number that other controls have for something else.
pub(super) fn name_of(number: i64) -> Option<&'static str> {
    match number {
        5420 => Some("_x"),
        5421 => Some("_y"),
        5422 => Some("_z"),
        _ => None,
    }
}

impl Predefined {
    /// The value, or what is missing where nothing says it.
    pub(super) fn get(&self, name: PredefinedName) -> Result<f64, &'static str> {
        let truth = |is: bool| Some(f64::from(is));
        let (value, missing) = match name {
            PredefinedName::Place(_) if self.is_turned => (
                None,
                "the place of the tool (LinuxCNC), which is not read under G68 or G16: write the \
                 number, or read it before",
            ),
            PredefinedName::Place(axis) => (
                self.place.get(axis).copied().flatten(),
                "the place of the tool (LinuxCNC), which is not known here: state X, Y and Z by \
                 rapid moves before",
            ),
            PredefinedName::Metric => (self.inches.and_then(|is| truth(!is)), UNIT),
            PredefinedName::Imperial => (self.inches.and_then(truth), UNIT),
            PredefinedName::Absolute => (truth(!self.relative), ""),
            PredefinedName::Incremental => (truth(self.relative), ""),
            PredefinedName::Feed => (
                self.feed,
                "the feed (LinuxCNC), which is not known here: write F before, behind G20 or G21",
            ),
            PredefinedName::Rpm => (
                self.rpm,
                "the spindle's speed (LinuxCNC), which is not known here: write S before",
            ),
        };
        value.ok_or(missing)
    }
}

const UNIT: &str = "the unit (LinuxCNC), which nothing says: write G20 or G21 before";
