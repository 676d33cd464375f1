//! Bad input: a good robot and a good job with one thing broken in each row. Every row must give its
//! fault, at its line, and no other fault that only follows from it.

use std::path::Path;

use detune::input::{Reading, read_job, read_robot};
use detune::notes::{Code, Note, Place};

const URDF: &str = include_str!("../data/bad/two-link.urdf");
const ROBOT: &str = include_str!("../data/bad/robot.yaml");
const JOB: &str = include_str!("../data/bad/job.yaml");

/// Which file is broken.
#[derive(Debug, Clone, Copy, PartialEq)]
enum In {
    Urdf,
    Robot,
    Job,
}
use In::{Job, Robot, Urdf};

/// `from` becomes `to` (once); the one fault lies in file `at`, at the line that holds `line` (all of
/// the file for an empty one), and says all of `says`.
struct Row {
    broken: In,
    from: &'static str,
    to: &'static str,
    at: In,
    line: &'static str,
    says: &'static [&'static str],
}

const fn row(
    broken: In,
    from: &'static str,
    to: &'static str,
    line: &'static str,
    says: &'static [&'static str],
) -> Row {
    Row { broken, from, to, at: broken, line, says }
}

const fn elsewhere(
    broken: In,
    from: &'static str,
    to: &'static str,
    (at, line): (In, &'static str),
    says: &'static [&'static str],
) -> Row {
    Row { broken, from, to, at, line, says }
}

#[rustfmt::skip]
const ROWS: &[Row] = &[
    // robot.yaml: keys
    row(Robot, "elasticity:", "elastisity:", "elastisity", &["unknown key 'elastisity'", "did you mean 'elasticity'?"]),
    row(Robot, "  damping_ratio: 0.03", "  damping: 0.03", "damping: 0.03", &["elasticity: unknown key 'damping'"]),
    row(Robot, "stiffness_nm_per_rad: 555000", "stifness_nm_per_rad: 555000", "stifness", &["joint 'joint_1': unknown key 'stifness_nm_per_rad'", "did you mean 'stiffness_nm_per_rad'?"]),
    row(Robot, "note: for tests", "zzz: for tests", "zzz", &["unknown key 'zzz'", "known keys are", "urdf"]),
    row(Robot, "urdf: two-link.urdf\n", "", "# The two-link", &["missing key 'urdf'"]),
    row(Robot, "mass_kg: 1.5, ", "", "payload", &["payload: missing key 'mass_kg'"]),
    row(Robot, "stiffness_nm_per_rad: 138000, ", "", "joint_2:", &["joint 'joint_2': missing key 'stiffness_nm_per_rad'"]),
    row(Robot, "base: base_link", "base: base_link\nbase: link_1", "base: link_1", &["key 'base' is given twice; first at line 5"]),
    row(Robot, "corrections: []", "corrections: [{cause: payload}]", "corrections", &["correction 1: parameter 'mass_kg' is missing"]),
    row(Robot, "corrections: []", "corrections: [{cause: load_dependent_stiffness, at: joint_2, parameters: {saturation_nm: 100}}]", "corrections", &["correction 1: parameter 'change_per_nm' is missing"]),
    row(Robot, "stiffness_nm_per_rad: 555000", "stiffness_nm_per_rad: 1, stiffness_n_per_m: 1", "joint_1: {st", &["joint 'joint_1': has both"]),
    row(Robot, "gravity: true", "gravity: true\n  rigid: [joint_2]", "rigid", &["elasticity.rigid: 'joint_2' has a spring under elasticity.joints"]),
    row(Robot, "gravity: true", "gravity: true\n  rigid: [joint_9]", "rigid", &["elasticity.rigid: 'joint_9' is no moving joint of the URDF"]),
    row(Robot, "corrections: []", "total_mass_kg: 3", "total_mass", &["total_mass_kg is 3, must be more than the"]),
    row(Robot, "stiffness_nm_per_rad: 138000", "stiffness_nm_per_rad: 138000, std_percent: -1", "joint_2: {st", &["joint 'joint_2': std_percent is -1, must be a number from 0 to 100"]),
    row(Robot, "reflected_inertia_kgm2: 0.0", "reflected_inertia_kgm2: 0.0, std_percent: .inf", "reflected", &["drive of joint 'joint_1': std_percent is .inf, must be a number from 0 to 100"]),
    // robot.yaml: values
    row(Robot, "stiffness_nm_per_rad: 555000", "stiffness_nm_per_rad: -1.2e5", "joint_1: {st", &["joint 'joint_1': stiffness_nm_per_rad is -1.2e5, must be positive and finite"]),
    row(Robot, "stiffness_nm_per_rad: 555000", "stiffness_nm_per_rad: 0", "joint_1: {st", &["stiffness_nm_per_rad is 0, must be positive"]),
    row(Robot, "stiffness_nm_per_rad: 555000", "stiffness_nm_per_rad: .nan", "joint_1: {st", &["is .nan, must be positive and finite"]),
    row(Robot, "stiffness_nm_per_rad: 555000", "stiffness_nm_per_rad: .inf", "joint_1: {st", &["is .inf, must be positive and finite"]),
    row(Robot, "stiffness_nm_per_rad: 555000", "stiffness_nm_per_rad: 1e999", "joint_1: {st", &["is 1e999, must be positive and finite"]),
    row(Robot, "stiffness_nm_per_rad: 555000", "stiffness_nm_per_rad: \"555000\"", "joint_1: {st", &["is \"555000\", must be positive"]),
    row(Robot, "stiffness_nm_per_rad: 555000", "stiffness_nm_per_rad: 555 000", "joint_1: {st", &["is 555 000, must be"]),
    row(Robot, "stiffness_nm_per_rad: 555000", "stiffness_n_per_m: 555000", "joint_1: {st", &["stiffness_n_per_m given, must be stiffness_nm_per_rad, as the joint turns"]),
    row(Robot, "damping_nms_per_rad: 12.5", "damping_ns_per_m: 12.5", "joint_2:", &["damping_ns_per_m given, must be damping_nms_per_rad"]),
    row(Robot, "damping_nms_per_rad: 12.5", "damping_nms_per_rad: -1", "joint_2:", &["damping_nms_per_rad is -1, must be positive"]),
    row(Robot, "  damping_ratio: 0.03", "  damping_ratio: 3", "damping_ratio", &["elasticity.damping_ratio is 3, must be a number above 0 and at most 0.99"]),
    row(Robot, "-9.81]", "-9.81, 0]", "gravity_m", &["elasticity.gravity_m_per_s2 has 4 values, must be a list of 3 numbers"]),
    row(Robot, "-9.81]", ".nan]", "gravity_m", &["elasticity.gravity_m_per_s2[2] is .nan, must be a finite number"]),
    row(Robot, "gravity: true", "gravity: yes", "gravity: yes", &["elasticity.gravity is yes, must be true or false"]),
    row(Robot, "reflected_inertia_kgm2: 0.0", "reflected_inertia_kgm2: -1", "reflected", &["drive of joint 'joint_1': reflected_inertia_kgm2 is -1", "not negative"]),
    row(Robot, "mass_kg: 1.5", "mass_kg: -1", "payload", &["payload.mass_kg is -1, must be a finite number, not negative"]),
    row(Robot, "ixx: 0.1, iyy: 0.1, izz: 0.1", "ixx: 0.1, iyy: 0.1, izz: 0.4", "payload", &["payload: inertia fails the triangle inequality"]),
    row(Robot, "ixx: 0.1, iyy: 0.1, izz: 0.1", "ixx: -0.1, iyy: 0.1, izz: 0.1", "payload", &["payload: inertia is not positive"]),
    row(Robot, "com_m: [0, 0, 0.1]", "com_m: 0", "payload", &["payload.com_m is 0, must be a list of 3 numbers"]),
    row(Robot, "poses: 20", "poses: 2.5", "calibration", &["calibration.poses is 2.5, must be a whole number, at least 1"]),
    row(Robot, "heldout_rms_percent: 4.4", "heldout_rms_percent: -4", "calibration", &["calibration.heldout_rms_percent is -4", "from 0 to 100"]),
    row(Robot, "name: Two-link section", "name: 7", "name: 7", &["name is 7, must be text; put it in quotes"]),
    row(Robot, "drives:\n  joint_1: {reflected_inertia_kgm2: 0.0}", "drives: 5", "drives", &["drives is 5, must be a mapping"]),
    row(Robot, "joint_1: {stiffness_nm_per_rad: 555000, source: \"Table 1\"}", "joint_1:", "joint_1:", &["joint 'joint_1' is empty, must be a mapping"]),
    row(Robot, "extra: []", "extra: [{name: x, link: link_1, kind: bend, axis: [0, 1, 0], stiffness: 1.0e6}]", "extra", &["extra coordinate 'x': kind is bend, must be one of rotation, translation"]),
    row(Robot, "extra: []", "extra: [{name: x, link: link_1, kind: rotation, axis: [0, 0, 0], stiffness: 1.0e6}]", "extra", &["extra coordinate 'x': axis is [0, 0, 0], must have a direction"]),
    row(Robot, "extra: []", "extra: [{name: x, link: link_9, kind: rotation, axis: [0, 1, 0], stiffness: 1.0e6}]", "extra", &["extra coordinate 'x': the URDF has no link 'link_9'"]),
    row(Robot, "extra: []", "extra: [{name: joint_1, link: link_1, kind: rotation, axis: [0, 1, 0], stiffness: 1.0e6}]", "extra", &["name 'joint_1' is taken"]),
    // robot.yaml against the URDF
    row(Robot, "joint_2: {stiff", "joint_3: {stiff", "joint_3", &["joint 'joint_3': the URDF has no such joint; it has joint_1, joint_2"]),
    row(Robot, "base: base_link", "base: base", "base: base", &["base: the URDF has no link 'base'"]),
    row(Robot, "tip: tool0", "tip: tool1", "tip: tool1", &["tip: the URDF has no link 'tool1'"]),
    row(Robot, "link: tool0", "link: tool1", "payload", &["payload: the URDF has no link 'tool1'"]),
    row(Robot, "{joint_2: 1.0}", "{joint_7: 1.0}", "beta2", &["arm angle beta2: 'joint_7' is not a moving joint"]),
    row(Robot, "{joint_2: 1.0}", "{joint_2: 1.7e308}", "beta2", &["arm angle beta2: factor of 'joint_2' is 17", "must be from -1000000 to 1000000"]),
    row(Robot, "offset_rad: 0.25", "offset_rad: -1.0e7", "beta2", &["arm angle beta2: offset_rad is -10000000, must be from -1000000"]),
    row(Robot, "  joint_1: {reflected", "  joint_8: {reflected", "joint_8", &["drive of joint 'joint_8': the URDF has no such moving joint"]),
    row(Robot, "urdf: two-link.urdf", "urdf: three-link.urdf", "urdf:", &["urdf 'three-link.urdf': no such file"]),
    row(Robot, "urdf: two-link.urdf", "urdf: .", "urdf:", &["urdf '.': is a folder, must be a file"]),
    elsewhere(Robot, "urdf: two-link.urdf", "urdf: job.yaml", (Job, ""), &["not valid XML"]),
    row(Robot, "base: base_link", "base: base_lnk", "base: base_lnk", &["base: the URDF has no link 'base_lnk'; it has base_link, link_1, link_2, tool0; did you mean 'base_link'?"]),
    row(Robot, "mass_kg: 1.5", "mass_kg: 1.0e308", "payload", &["payload: mass is 1", "must be at most 10000000 kg"]),
    row(Robot, "com_m: [0, 0, 0.1]", "com_m: [0, 0, 1.0e200]", "payload", &["payload: centre of mass is [0, 0, 1", "must lie within 100000 m"]),
    row(Robot, "note: for tests", "note: \"a\\x1b[31m\"\nzz\u{7f}: 1", "zz", &["unknown key 'zz\\u{7f}'"]),
    // YAML as such
    row(Robot, "  damping_ratio: 0.03", "\tdamping_ratio: 0.03", "\tdamping", &["not valid YAML", "tab"]),
    row(Robot, "extra: []", "extra: [", "gravity: true", &["not valid YAML"]),
    row(Robot, "Two-link section\nnote: for tests", "&n Two-link\nnote: *n", "note: *n", &["aliases (*name) are not read"]),
    row(Robot, "extra: []", "extra: !list []", "extra", &["tag '!list' is not read"]),
    row(Robot, "drives:", "---\ndrives:", "---", &["second document"]),
    row(Robot, "note: for tests", "? [a, b]\n: c", "? [a", &["is used as a key"]),
    // URDF
    row(Urdf, "</robot>", "", "<robot", &["not valid XML: the file ends inside <robot>, which starts here"]),
    row(Urdf, "<robot name=\"two-link\">", "<robot name=\"two-link\" xmlns:xacro=\"http://www.ros.org/wiki/xacro\"><xacro:include/>", "<robot", &["unexpanded xacro"]),
    row(Urdf, "mass value=\"4.0\"", "mass value=\"-4.0\"", "-4.0", &["link 'link_1': mass is -4 kg, must not be negative"]),
    row(Urdf, "mass value=\"4.0\"", "mass value=\"NaN\"", "NaN", &["link 'link_1': <mass> value is \"NaN\", must be a finite number"]),
    row(Urdf, "mass value=\"4.0\"", "mass value=\"inf\"", "inf\"", &["must be a finite number"]),
    row(Urdf, "mass value=\"4.0\"", "mass value=\"4,0\"", "4,0", &["<mass> value is \"4,0\""]),
    row(Urdf, "<mass value=\"4.0\"/>", "", "<inertial>", &["link 'link_1': <inertial> has no <mass>"]),
    row(Urdf, "iyy=\"0.30\"", "iyy=\"3.0\"", "iyy=\"3.0\"", &["link 'link_1': inertia fails the triangle inequality (ixx 0.005 + izz 0.3 < iyy 3 kg·m²)"]),
    row(Urdf, "ixx=\"0.005\"", "ixx=\"-0.005\"", "-0.005", &["link 'link_1': inertia is not positive"]),
    row(Urdf, "ixy=\"0\" ixz=\"0\" iyy=\"0.30\"", "ixz=\"0\" iyy=\"0.30\"", "iyy=\"0.30\"", &["link 'link_1': <inertia> has no ixy"]),
    row(Urdf, "xyz=\"0.7 0 0\"", "xyz=\"0 abc 1\"", "abc", &["joint 'joint_2': <origin> xyz is \"0 abc 1\", must be 3 finite numbers"]),
    row(Urdf, "xyz=\"0.7 0 0\"", "xzy=\"0.7 0 0\"", "xzy", &["joint 'joint_2': <origin> has no attribute 'xzy', only xyz, rpy, quat_xyzw"]),
    row(Urdf, "ixy=\"0\"", "ixy=\"0\" izx=\"0\"", "izx", &["link 'link_1': <inertia> has no attribute 'izx'"]),
    row(Urdf, "mass value=\"4.0\"", "mass value=\"4.0\" unit=\"kg\"", "unit", &["link 'link_1': <mass> has no attribute 'unit'"]),
    row(Urdf, "<axis xyz=\"0 -1 0\"/>", "<axes xyz=\"0 -1 0\"/>", "<axes", &["joint 'joint_1': <axes> is not known; did you mean <axis>?"]),
    row(Urdf, "<inertial>", "<inertial><orgin xyz=\"0.1 0 0\"/>", "<orgin", &["link 'link_1': <orgin> is not known; did you mean <origin>?"]),
    row(Urdf, "xyz=\"0.7 0 0\"", "xyz=\"0.7 0 abc 0\"", "abc", &["must be 3 finite numbers"]),
    row(Urdf, "<axis xyz=\"0 -1 0\"/>\n    <limit lower=\"-3.2\" upper=\"3.2\" effort=\"0\" velocity=\"3.14\"/>\n  </joint>\n  <joint name=\"joint_2\"", "<axis xyz=\"0 0 0\"/></joint>\n  <joint name=\"joint_2\"", "0 0 0\"/></joint>", &["joint 'joint_1': axis is [0, 0, 0], must have a direction"]),
    row(Urdf, "lower=\"-3.2\" upper=\"3.2\"", "lower=\"3.2\" upper=\"-3.2\"", "lower=\"3.2\"", &["joint 'joint_1': limits are 3.2..-3.2, must be finite and ascending"]),
    row(Urdf, "velocity=\"3.14\"", "velocity=\"-1\"", "velocity=\"-1\"", &["velocity limit is -1"]),
    row(Urdf, "velocity=\"3.14\"", "velocity=\"1e-300\"", "1e-300", &["joint 'joint_1': velocity limit is 0.000", "must be finite and at least 0.000001"]),
    row(Urdf, "type=\"revolute\"", "type=\"hinge\"", "hinge", &["joint 'joint_1': type is 'hinge', must be one of revolute"]),
    row(Urdf, "    <parent link=\"link_1\"/>\n", "", "name=\"joint_2\"", &["joint 'joint_2': has no <parent"]),
    row(Urdf, "    <child link=\"link_2\"/>\n", "", "name=\"joint_2\"", &["joint 'joint_2': has no <child"]),
    row(Urdf, "<parent link=\"link_1\"/>", "<parent link=\"link_9\"/>", "link_9", &["joint 'joint_2': parent link 'link_9' does not exist"]),
    row(Urdf, "<link name=\"tool0\"/>", "<link name=\"tool0\"/><link name=\"link_1\"/>", "<link name=\"tool0\"/><link", &["link 'link_1': name is taken by another link"]),
    row(Urdf, "<child link=\"tool0\"/>", "<child link=\"link_1\"/>", "<child link=\"link_1\"/>\n    <origin", &["joint 'tool0': link 'link_1' is already the child of joint 'joint_1'"]),
    row(Urdf, "<link name=\"tool0\"/>", "<link name=\"tool0\"/>\n<link name=\"loose\"/>", "loose", &["link 'loose': a second root beside 'base_link'"]),
    // job.yaml: keys
    row(Job, "spindle_rpm: 1100", "spindel_rpm: 1100", "spindel", &["operation 'rough': unknown key 'spindel_rpm'; did you mean 'spindle_rpm'?"]),
    row(Job, "operations:", "operation:", "operation:", &["unknown key 'operation'; did you mean 'operations'?"]),
    row(Job, "feed_mm_per_min: 600", "feed: 600", "feed: 600", &["operation 'rough': unknown key 'feed'", "feed_mm_per_min"]),
    row(Job, "teeth: 2", "theeth: 2", "theeth", &["tool: unknown key 'theeth'; did you mean 'teeth'?"]),
    row(Job, "    feed_mm_per_min: 600\n", "", "name: rough", &["operation 'rough': missing key 'feed_mm_per_min'"]),
    row(Job, "  - name: rough\n    spindle_rpm", "  - spindle_rpm", "- spindle_rpm", &["operation 1: missing key 'name'"]),
    row(Job, "teeth: 2, ", "", "tool:", &["tool: missing key 'teeth'"]),
    row(Job, "robot: robot.yaml\n", "", "# Every", &["missing key 'robot'"]),
    row(Job, "    spindle_rpm: 1100\n", "", "name: rough", &["operation 'rough': missing key 'spindle_rpm' (or 'spindle_schedule')"]),
    row(Job, "    spindle_rpm: 1100\n", "    spindle_rpm: 1100\n    spindle_schedule: [{s: 0, rpm: 600}, {s: 1, rpm: 700}]\n", "schedule: [{s: 0, rpm: 600}", &["has both spindle_rpm and spindle_schedule"]),
    row(Job, "      joints_deg:\n", "      program: {file: robot.yaml}\n      joints_deg:\n", "program", &["path has joints_deg and program, must have one of them"]),
    row(Job, "      joints_deg:\n        - [0, 20]\n        - [10, 25]\n        - [20, 30]\n", "      {}\n", "    path:", &["operation 'rough': path has no waypoints, must have one of joints_deg, poses, program"]),
    row(Job, "name: finish", "name: rough", "name: rough\n    spindle_schedule", &["operation 'rough': name is taken by the operation at line 10"]),
    row(Job, "robot: robot.yaml", "robot: rebot.yaml", "robot:", &["robot 'rebot.yaml': no such file"]),
    row(Job, "robot: robot.yaml", "robot: ..", "robot:", &["robot '..': is a folder, must be a file"]),
    // job.yaml: values
    row(Job, "teeth: 2", "teeth: 0", "tool:", &["tool.teeth is 0, must be a whole number from 1 to 1000"]),
    row(Job, "teeth: 2", "teeth: 2.5", "tool:", &["tool.teeth is 2.5, must be a whole number"]),
    row(Job, "teeth: 2", "teeth: 3", "tool:", &["tool.pitch_deg has 2 angles, must have one for each of the 3 teeth"]),
    row(Job, "[170, 190]", "[170, 180]", "tool:", &["tool.pitch_deg adds up to 350, must be 360"]),
    row(Job, "[170, 190]", "[-10, 370]", "tool:", &["tool.pitch_deg[0] is -10, must be positive"]),
    row(Job, "diameter_mm: 12", "diameter_mm: 0", "tool:", &["tool.diameter_mm is 0, must be positive"]),
    row(Job, "xyz_m: [0, 0, 0.15]", "xyz_m: [0, 0]", "tcp:", &["tcp.xyz_m has 2 values, must be a list of 3 numbers"]),
    row(Job, "xyz_m: [0, 0, 0.15]", "xyz_m: [0, .inf, 0]", "tcp:", &["tcp.xyz_m[1] is .inf, must be a finite number"]),
    row(Job, "xyz_m: [0.9, 0, 0.4]", "xyz_m: [0.9, 0, 0.4, 1]", "work_object:", &["work_object.xyz_m has 4 values"]),
    row(Job, "min_rpm: 500", "min_rpm: 7000", "spindle: {", &["spindle.min_rpm is 7000, must not be above max_rpm, 6000"]),
    row(Job, "min_rpm: 500", "min_rpm: 0", "spindle: {", &["spindle.min_rpm is 0, must be a number above 0"]),
    row(Job, "min_rpm: 500", "min_rpm: 1.0e308", "min_rpm", &["spindle.min_rpm is 1.0e308, must be a number above 0 and at most 10000000"]),
    row(Job, "spindle_rpm: 1100", "spindle_rpm: 6100", "6100", &["operation 'rough': spindle_rpm is 6100, must lie in the spindle's range 500..6000"]),
    row(Job, "spindle_rpm: 1100", "spindle_rpm: \"1100\"", "\"1100\"", &["spindle_rpm is \"1100\", must be positive and finite; in quotes it is text: write it without them"]),
    row(Job, "spindle_rpm: 1100", "spindle_rpm: 1100 rpm", "1100 rpm", &["operation 'rough': spindle_rpm is 1100 rpm, must be positive and finite; write a plain number in rpm"]),
    row(Job, "spindle_rpm: 1100", "spindle_rpm: -1100", "-1100", &["operation 'rough': spindle_rpm is -1100, must be positive"]),
    row(Job, "rpm: 1350", "rpm: 13500", "13500", &["operation 'finish': spindle_schedule[1].rpm is 13500, must lie in the spindle's range"]),
    row(Job, "{s: 0.0, rpm: 1200}", "{s: 0.0, rpm: 1200}, {s: 0.0, rpm: 1300}", "1300", &["spindle_schedule[1].s is 0, must be above the one before, 0"]),
    row(Job, "feed_mm_per_min: 600", "feed_mm_per_min: 0", "min: 0", &["operation 'rough': feed_mm_per_min is 0, must be positive and finite"]),
    row(Job, "feed_mm_per_min: 600", "feed_mm_per_min: -5", "-5", &["feed_mm_per_min is -5, must be positive"]),
    row(Job, "feed_mm_per_min: 600", "feed_mm_per_min: fast", "fast", &["feed_mm_per_min is fast, must be positive and finite"]),
    row(Job, "direction: climb", "direction: climbing", "cutting", &["operation 'rough': cutting.direction is climbing, must be one of climb, conventional, slot, drill; did you mean 'climb'?"]),
    row(Job, "axial_depth_mm: 2", "axial_depth_mm: 1e300", "cutting", &["operation 'rough': cutting.axial_depth_mm is"]),
    row(Job, "radial_depth_mm: 6", "radial_depth_mm: 900", "cutting", &["operation 'rough': cutting.radial_depth_mm is 900, must not be above tool.diameter_mm"]),
    row(Job, "radial_depth_mm: 6", "radial_depth_mm: 0", "cutting", &["operation 'rough': cutting.radial_depth_mm is 0"]),
    row(Job, "[10, 25]", "[10, 25, 3]", "[10, 25, 3]", &["operation 'rough': waypoint 2 has 3 values, must have 2: joint_1, joint_2"]),
    row(Job, "[10, 25]", "[]", "- []", &["waypoint 2 has 0 values, must have 2"]),
    row(Job, "[10, 25]", "[10, 200]", "[10, 200]", &["operation 'rough': waypoint 2: joint 'joint_2' is 200.000 deg, must lie in -183.346..183.346 deg"]),
    row(Job, "[10, 25]", "[10, .nan]", ".nan", &["operation 'rough': path.joints_deg[1][1] is .nan, must be a finite number"]),
    row(Job, "[10, 25]", "[10, 2O]", "2O", &["path.joints_deg[1][1] is 2O, must be a finite number"]),
    row(Job, "[10, 25]", "15", "- 15", &["path.joints_deg[1] is 15, must be a list of numbers"]),
    row(Job, "      joints_deg:\n        - [0, 20]\n        - [10, 25]\n        - [20, 30]\n", "      joints_deg: []\n", "joints_deg", &["operation 'rough': path.joints_deg is an empty list, must be a list of at least 1 list"]),
    row(Job, "start_near_deg: [10, 10]", "start_near_deg: [10]", "start_near", &["operation 'finish': start_near_deg has 1 value, must have 2: joint_1, joint_2"]),
    row(Job, "start_near_deg: [10, 10]", "start_near_deg: [1000, 10]", "start_near", &["start_near_deg: joint 'joint_1' is 1000.000 deg"]),
    row(Job, "{xyz_mm: [0, 100, 0]}", "{rpy_deg: [0, 1, 0]}", "rpy_deg: [0, 1, 0]", &["operation 'finish': path.poses[1]: missing key 'xyz_mm'"]),
    row(Job, "{xyz_mm: [0, 100, 0]}", "{xyz_mm: [0, 100]}", "[0, 100]", &["operation 'finish': path.poses[1].xyz_mm has 2 values"]),
    row(Job, "{xyz_mm: [0, 100, 0]}", "{xyz: [0, 100, 0], xyz_mm: [0, 0, 0]}", "xyz:", &["path.poses[1]: unknown key 'xyz'; did you mean 'xyz_mm'?"]),
    row(Job, "separation_percent: 8", "separation_percent: 101", "101", &["policy.separation_percent is 101, must be a number above 0 and at most 100"]),
    row(Job, "separation_percent: 8", "separation_percent: 0", "percent: 0", &["policy.separation_percent is 0"]),
    row(Job, "separation_percent: 8", "separation_percent: 8\n  model_uncertainty_percent: -1", "uncertainty", &["policy.model_uncertainty_percent is -1, must be a number from 0 to 100"]),
    row(Job, "tooth_passing_harmonics: 3", "tooth_passing_harmonics: 1001", "1001", &["policy.tooth_passing_harmonics is 1001, must be a whole number from 0 to 1000"]),
    row(Job, "tooth_passing_harmonics: 3", "tooth_passing_harmonics: 0", "tooth_passing", &["both 0"]),
    row(Job, "spindle_harmonics: 0", "spindle_harmonics: -1", "-1", &["policy.spindle_harmonics is -1"]),
    row(Job, "[49, 51]", "[51, 49]", "ignore_hz", &["policy.ignore_hz[0] is [51, 49], must be ascending"]),
    row(Job, "min_tip_response_um_per_n: 0.5", "min_tip_response_um_per_n: -0.5", "-0.5", &["policy.min_tip_response_um_per_n is -0.5"]),
];

/// Rows with more than one fault: all of them, as (part of the line's text, part of the message).
type Several = (In, &'static str, &'static str, &'static [(&'static str, &'static str)]);

#[rustfmt::skip]
const SEVERAL: &[Several] = &[
    (Urdf, "<parent link=\"base_link\"/>", "<parent link=\"link_2\"/>", &[
        ("<link name=\"link_1\"", "link 'link_1': is part of a loop of joints"),
        ("<link name=\"link_2\"", "link 'link_2': is part of a loop of joints"),
        ("<link name=\"tool0\"", "link 'tool0': is part of a loop of joints"),
    ]),
    (Urdf, "<mass value=\"4.0\"/>\n      <inertia ixx=\"0.005\"", "<mass/>\n      <inertia", &[
        ("<mass/>", "link 'link_1': <mass> has no value"),
        ("<inertia ixy", "link 'link_1': <inertia> has no ixx"),
    ]),
    (Job, "        - [0, 20]\n        - [10, 25]", "        - [0, x]\n        - [400, -400]", &[
        ("[0, x]", "path.joints_deg[0][1] is x, must be a finite number"),
        ("-400", "waypoint 2: joint 'joint_1' is 400.000 deg"),
        ("-400", "waypoint 2: joint 'joint_2' is -400.000 deg"),
    ]),
    (Job, "spindle_rpm: 1100\n    feed_mm_per_min: 600", "spindle_rpm: 1\n    feed_mm_per_min: 0\n    fed: 1", &[
        ("spindle_rpm: 1\n", "spindle_rpm is 1, must lie in the spindle's range"),
        ("min: 0", "feed_mm_per_min is 0"),
        ("fed: 1", "unknown key 'fed'"),
    ]),
];

fn line_of(text: &str, part: &str) -> usize {
    let at = text.find(part).unwrap_or_else(|| panic!("{part:?} is not there"));
    // The comment above the first key has line 1; a missing key of the file is told at that first key.
    let line = 1 + text[..at].matches('\n').count();
    if part.starts_with("# ") { 2 } else { line }
}

fn job_errors(path: &Path) -> Vec<Note> {
    read_job(path, &mut Reading::default()).err().unwrap_or_default()
}

fn robot_errors(path: &Path) -> Vec<Note> {
    read_robot(path, &mut Reading::default()).err().unwrap_or_default()
}

fn faults_of(robot: &[u8], urdf: &[u8], job: &[u8]) -> Vec<Note> {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in [("robot.yaml", robot), ("two-link.urdf", urdf), ("job.yaml", job)] {
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    let faults = job_errors(&folder.path().join("job.yaml"));
    faults
        .into_iter()
        .map(|mut note| {
            note.place.file =
                note.place.file.map(|f| f.strip_prefix(folder.path()).unwrap().into());
            note
        })
        .collect()
}

/// The faults with one thing broken, and the three files as broken.
fn broken(which: In, from: &str, to: &str) -> (Vec<Note>, [String; 3]) {
    let change = |of: In, text: &str| {
        if of != which {
            return text.to_owned();
        }
        assert!(text.contains(from), "{from:?} is not in {of:?}");
        text.replacen(from, to, 1)
    };
    let texts = [change(Robot, ROBOT), change(Urdf, URDF), change(Job, JOB)];
    let [robot, urdf, job] = &texts;
    (faults_of(robot.as_bytes(), urdf.as_bytes(), job.as_bytes()), texts)
}

fn name_and_text(at: In, [robot, urdf, job]: &[String; 3]) -> (&Path, &str) {
    match at {
        Robot => (Path::new("robot.yaml"), robot),
        Urdf => (Path::new("two-link.urdf"), urdf),
        Job => (Path::new("job.yaml"), job),
    }
}

#[test]
fn the_unbroken_files_are_good() {
    assert_eq!(faults_of(ROBOT.as_bytes(), URDF.as_bytes(), JOB.as_bytes()), []);
}

#[test]
fn every_broken_thing_is_told_at_its_line_and_nothing_else_is() {
    let mut wrong = Vec::new();
    for row in ROWS {
        let (faults, texts) = broken(row.broken, row.from, row.to);
        let (file, text) = name_and_text(row.at, &texts);
        let fits = match &faults[..] {
            [fault] => {
                fault.place.file.as_deref() == Some(file)
                    && (row.line.is_empty() || fault.place.line == Some(line_of(text, row.line)))
                    && row.says.iter().all(|says| fault.what.contains(says))
            }
            _ => false,
        };
        if !fits {
            let told: Vec<String> = faults.iter().map(Note::to_string).collect();
            wrong.push(format!("{:?} → {:?}:\n    {}", row.from, row.to, told.join("\n    ")));
        }
    }
    assert!(wrong.is_empty(), "{} of {}\n{}", wrong.len(), ROWS.len(), wrong.join("\n"));
}

#[test]
fn where_one_break_has_several_faults_all_are_told() {
    for (which, from, to, expected) in SEVERAL {
        let (faults, texts) = broken(*which, from, to);
        let (_, text) = name_and_text(*which, &texts);
        let told: Vec<String> = faults.iter().map(Note::to_string).collect();
        for (line, says) in *expected {
            let line = Some(line_of(text, line));
            let found =
                faults.iter().any(|fault| fault.place.line == line && fault.what.contains(says));
            assert!(found, "{says:?} at {line:?} not in\n{}", told.join("\n"));
        }
        assert!(faults.len() == expected.len(), "{}", told.join("\n"));
    }
}

#[test]
fn files_that_are_no_text_are_refused() {
    let good = [ROBOT.as_bytes(), URDF.as_bytes(), JOB.as_bytes()];
    let with = |which: usize, bytes: &[u8]| {
        let mut files = good;
        files[which] = bytes;
        let faults = faults_of(files[0], files[1], files[2]);
        assert_eq!(faults.len(), 1, "{faults:?}");
        faults[0].to_string()
    };
    let broken = |text: &str| {
        let line = 1 + text.lines().position(|l| l.contains("name")).unwrap();
        (
            line,
            text.replacen("name", "na\u{0}me", 1)
                .into_bytes()
                .iter()
                .map(|&b| if b == 0 { 0xFF } else { b })
                .collect::<Vec<u8>>(),
        )
    };
    for (which, name, text) in
        [(0, "robot.yaml", ROBOT), (1, "two-link.urdf", URDF), (2, "job.yaml", JOB)]
    {
        let (line, bytes) = broken(text);
        assert_eq!(
            with(which, &bytes),
            format!("{name}:{line}: byte 0xFF is not UTF-8; save the file as UTF-8")
        );
        let wide: Vec<u8> = "\u{FEFF}"
            .encode_utf16()
            .chain(text.encode_utf16())
            .flat_map(u16::to_le_bytes)
            .collect();
        assert_eq!(with(which, &wide), format!("{name}:1: is UTF-16, must be UTF-8"));
    }
    assert_eq!(with(0, b""), "robot.yaml: is empty, must hold keys and values");
    assert_eq!(with(2, b"# nothing\n"), "job.yaml: is empty, must hold keys and values");
    assert!(with(1, b"").starts_with("two-link.urdf:1: not valid XML"));
    assert_eq!(
        with(2, b"- 1\n- 2\n"),
        "job.yaml:1: the file is a list of 2, must be a mapping of keys to values"
    );
}

#[test]
fn line_ends_and_byte_order_marks_of_other_systems_are_read() {
    let other = |text: &str| format!("\u{FEFF}{}", text.replace('\n', "\r\n"));
    let [robot, urdf, job] = [ROBOT, URDF, JOB].map(other);
    assert_eq!(faults_of(robot.as_bytes(), urdf.as_bytes(), job.as_bytes()), []);
    let job = job.replace("teeth: 2", "teeth: 0");
    let urdf = urdf.replace("\"4.0\"", "\"x\"");
    let faults = faults_of(robot.as_bytes(), urdf.as_bytes(), job.as_bytes());
    let lines: Vec<_> = faults.iter().map(|fault| fault.place.line).collect();
    assert_eq!(lines, [Some(line_of(JOB, "teeth")), Some(line_of(URDF, "\"4.0\""))], "{faults:?}");
}

#[test]
fn folders_and_missing_files_are_told() {
    let folder = tempfile::tempdir().unwrap();
    for (path, what) in [
        (folder.path().to_owned(), "is a folder, must be a file"),
        (folder.path().join("none.yaml"), "no such file"),
    ] {
        for faults in [job_errors(&path), robot_errors(&path)] {
            let expected = Note::error(Code::Unreadable, Place::file(&path), what);
            assert_eq!(faults, [expected]);
        }
    }
}

#[test]
fn bombs_are_refused() {
    let laughs: String = (1..30)
        .map(|i| format!("a{i}: &a{i} [{}]\n", vec![format!("*a{}", i - 1); 10].join(", ")))
        .collect();
    let bombs = [
        ("aliases", format!("a0: &a0 [x]\n{laughs}")),
        ("flow", "[".repeat(1_000_000)),
        ("block", "- ".repeat(1_000_000)),
        ("maps", "{a: ".repeat(1_000_000)),
        ("keys", "? ".repeat(1_000_000)),
        ("many", format!("operations: [{}]", "[],".repeat(7_000_000))),
        ("same", "name: x\n".repeat(200_000)),
        ("long", format!("{}: 1", "n".repeat(1_000_000))),
        ("unknown", (0..200_000).map(|i| format!("k{i}: x\n")).collect()),
    ];
    for (name, bomb) in bombs {
        let faults = faults_of(ROBOT.as_bytes(), URDF.as_bytes(), bomb.as_bytes());
        assert!(!faults.is_empty() && faults.len() < 1000, "{name}: {}", faults.len());
    }
    let deep = format!("<robot name=\"r\">{}", "<link>".repeat(1_000_000));
    assert!(!faults_of(ROBOT.as_bytes(), deep.as_bytes(), JOB.as_bytes()).is_empty());
    let entities =
        format!("<!DOCTYPE r [<!ENTITY a \"{}\">]><robot name=\"&a;\"/>", "x".repeat(1000));
    assert!(!faults_of(ROBOT.as_bytes(), entities.as_bytes(), JOB.as_bytes()).is_empty());

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("huge.yaml");
    std::fs::File::create(&path).unwrap().set_len(100_000_000).unwrap();
    for (faults, most) in [(job_errors(&path), 64), (robot_errors(&path), 1)] {
        let what = format!("is larger than {most} MiB, the limit");
        assert_eq!(faults[0].what, what);
    }
}

#[test]
fn a_flood_of_faults_is_cut_short_and_counted() {
    let rows = "        - [0, 20, 1]\n".repeat(100_000);
    let job = JOB.replace("        - [0, 20]\n", &rows);
    let faults = faults_of(ROBOT.as_bytes(), URDF.as_bytes(), job.as_bytes());
    assert!(faults.len() < 1000);
    assert_eq!(faults.last().unwrap().to_string(), "job.yaml: and 99800 more");
}

/// Random changes of bytes: whatever comes out, the reader must not panic, and must either read the
/// files or say what is wrong with them.
#[test]
fn random_changes_never_panic() {
    use rand::{RngExt, SeedableRng};
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(7);
    let words: &[&[u8]] = &[
        b"-", b": ", b"\n", b"  ", b"[", b"]", b"{", b"}", b"\"", b"<", b"/>", b"0", b"1e999",
        b".nan", b"&a ", b"*a", b"\t", b"\xFF", b"#", b"|\n", b"null",
    ];
    for round in 0..1500 {
        let mut files = [ROBOT, URDF, JOB].map(|text| text.as_bytes().to_vec());
        let file = &mut files[round % 3];
        for _ in 0..rng.random_range(1..4) {
            let at = rng.random_range(0..file.len());
            match rng.random_range(0..4) {
                0 => file[at] = rng.random(),
                1 => {
                    file.remove(at);
                }
                2 => {
                    let word = words[rng.random_range(0..words.len())];
                    file.splice(at..at, word.iter().copied());
                }
                _ => {
                    let end = (at + rng.random_range(1..40)).min(file.len());
                    let piece = file[at..end].to_vec();
                    let to = rng.random_range(0..file.len());
                    file.splice(to..to, piece);
                }
            }
        }
        for fault in faults_of(&files[0], &files[1], &files[2]) {
            assert!(!fault.what.is_empty() && fault.place.line != Some(0), "{fault:?}");
        }
    }
}

#[test]
fn a_waypoint_at_a_rounded_limit_is_within_it() {
    // The limit is 3.2 rad = 183.3465°; 1e-4 rad, 0.0057°, beyond it is rounding.
    for (deg, allowed) in
        [("183.35", true), ("-183.35", true), ("183.36", false), ("-183.36", false)]
    {
        let job = JOB.replace("[10, 25]", &format!("[10, {deg}]"));
        let faults = faults_of(ROBOT.as_bytes(), URDF.as_bytes(), job.as_bytes());
        assert_eq!(faults.is_empty(), allowed, "{deg}: {faults:?}");
    }
}

#[test]
fn a_urdf_that_is_cut_off_is_told_where_its_last_element_starts() {
    // Cut inside the second link's inertia, behind a comment that looks like a tag.
    let cut = URDF.replacen("<link name=\"link_2\">", "<link name=\"link_2\"><!-- <a> -->", 1);
    let start = cut.find("<link name=\"link_2\">").unwrap();
    let end = start + cut[start..].find("</inertial>").unwrap();
    let faults = faults_of(ROBOT.as_bytes(), &cut.as_bytes()[..end], JOB.as_bytes());
    let [fault] = &faults[..] else { panic!("{faults:?}") };
    assert!(fault.what.contains("the file ends inside <inertial>"), "{fault}");
    assert_eq!(
        fault.place.line,
        Some(1 + cut[..start + cut[start..].find("<inertial>").unwrap()].matches('\n').count())
    );
}

#[test]
fn a_nul_byte_is_told_at_its_line() {
    let job = JOB.replacen("teeth: 2", "teeth: \0", 1);
    let faults = faults_of(ROBOT.as_bytes(), URDF.as_bytes(), job.as_bytes());
    let [fault] = &faults[..] else { panic!("{faults:?}") };
    assert_eq!(fault.place.line, Some(line_of(JOB, "teeth: 2")));
    assert!(fault.what.starts_with("holds a NUL byte"), "{fault}");
}

#[test]
fn a_folder_for_the_robot_is_the_file_in_it() {
    let folder = tempfile::tempdir().unwrap();
    let arm = folder.path().join("arm");
    std::fs::create_dir(&arm).unwrap();
    std::fs::write(arm.join("robot.yaml"), ROBOT).unwrap();
    let path = folder.path().join("job.yaml");
    let told = |robot: &str| {
        std::fs::write(&path, JOB.replacen("robot: robot.yaml", &format!("robot: {robot}"), 1))
            .unwrap();
        job_errors(&path)[0].what.clone()
    };
    let in_it = arm.join("two-link.urdf");
    let lacks = format!("urdf 'two-link.urdf': no such file: looked for {}", in_it.display());
    assert_eq!(told("arm"), lacks);
    assert_eq!(told("."), "robot '.': is a folder, must be a file");
    // What is looked for is shown where the name does not show it.
    let there = arm.join("none.yaml");
    assert!(
        told("arm/none.yaml").ends_with(&format!("no such file: looked for {}", there.display()))
    );
    assert!(told(&there.display().to_string()).ends_with("none.yaml': no such file"));
}

/// The faults do not hide the remarks, and every file that was named is known.
#[test]
fn remarks_and_files_are_known_where_there_are_faults() {
    let folder = tempfile::tempdir().unwrap();
    let urdf = URDF.replacen("lower=\"-3.2\" upper=\"3.2\"", "", 1);
    for (name, text) in [
        ("robot.yaml", ROBOT),
        ("two-link.urdf", &urdf),
        ("job.yaml", &JOB.replacen("teeth: 2", "teeth: 0", 1)),
    ] {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let mut reading = Reading::default();
    let faults = read_job(&folder.path().join("job.yaml"), &mut reading).unwrap_err();
    assert_eq!(faults.len(), 1, "{faults:?}");
    assert_eq!(reading.warnings.len(), 1, "{:?}", reading.warnings);
    assert!(reading.warnings[0].what.contains("has no <limit>"));
    let names: Vec<_> = reading.files.iter().map(|file| file.file_name().unwrap()).collect();
    assert_eq!(names, ["job.yaml", "robot.yaml", "two-link.urdf"]);
}

/// Every place of `value` that a key of a mapping leads to.
fn keyed_places(value: &serde_yaml::Value, at: &[String], found: &mut Vec<Vec<String>>) {
    let children: Vec<(String, &serde_yaml::Value)> = match value {
        serde_yaml::Value::Mapping(map) => {
            map.iter().map(|(key, value)| (key.as_str().unwrap().to_owned(), value)).collect()
        }
        serde_yaml::Value::Sequence(items) => {
            items.iter().enumerate().map(|(i, item)| (i.to_string(), item)).collect()
        }
        _ => return,
    };
    for (step, child) in children {
        let place = [at, &[step]].concat();
        keyed_places(child, &place, found);
        if value.is_mapping() {
            found.push(place);
        }
    }
}

/// The document with the value at `place` null, or with its key left out.
fn without(document: &serde_yaml::Value, place: &[String], leave_out: bool) -> String {
    let (key, way) = place.split_last().unwrap();
    let mut document = document.clone();
    let owner = way.iter().fold(&mut document, |value, step| match step.parse::<usize>() {
        Ok(index) => &mut value[index],
        Err(_) => &mut value[step.as_str()],
    });
    let owner = owner.as_mapping_mut().unwrap();
    if leave_out {
        owner.shift_remove(key.as_str());
    } else {
        owner.insert(key.as_str().into(), serde_yaml::Value::Null);
    }
    serde_yaml::to_string(&document).unwrap()
}

#[test]
fn a_key_without_a_value_is_one_that_is_not_there() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    for (name, text) in [("two-link.urdf", URDF), ("robot.yaml", ROBOT), ("job.yaml", JOB)] {
        write(name, text);
    }
    // What was read, but for the lines that it stood in.
    let read = || {
        let read = read_job(&folder.path().join("job.yaml"), &mut Reading::default()).ok()?;
        let shown = format!("{read:#?}");
        let lines: Vec<&str> = shown.lines().filter(|l| !l.trim().starts_with("line: ")).collect();
        Some(lines.join("\n"))
    };
    let (mut compared, mut read_ones, mut wrong) = (0, 0, Vec::new());
    for (name, text) in [("robot.yaml", ROBOT), ("job.yaml", JOB)] {
        let document: serde_yaml::Value = serde_yaml::from_str(text).unwrap();
        let mut places = Vec::new();
        keyed_places(&document, &[], &mut places);
        for place in places {
            let [null, absent] = [false, true].map(|leave_out| {
                write(name, &without(&document, &place, leave_out));
                read()
            });
            compared += 1;
            read_ones += usize::from(null.is_some());
            // One that is refused harms nobody: a joint is named for what it says of it.
            if null.is_some() && null != absent {
                wrong.push(format!("{name}: {}", place.join(".")));
            }
        }
        write(name, text);
    }
    assert_eq!(wrong, [""; 0]);
    assert!(compared > 80 && read_ones > 30, "{compared}, {read_ones}");
}

#[test]
fn a_file_of_another_kind_has_that_one_fault() {
    let said = |faults: Vec<Note>| {
        faults.iter().map(|fault| fault.what.to_string()).collect::<Vec<_>>().join("; ")
    };
    let repository = Path::new(env!("CARGO_MANIFEST_DIR"));
    let robot = repository.join("robots/irb1600/robot.yaml");
    let job = repository.join("jobs/pocket.yaml");
    let session = repository.join("robots/two-link/session.yaml");
    for (faults, is, must_be) in [
        (job_errors(&robot), "this is a robot", "must be a job"),
        (job_errors(&session), "this is a session", "must be a job"),
        (robot_errors(&job), "this is a job", "must be a robot"),
    ] {
        assert_eq!(faults.len(), 1, "{faults:?}");
        assert!(said(faults.clone()).contains(is) && said(faults).contains(must_be));
    }
}
