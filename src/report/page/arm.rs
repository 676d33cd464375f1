//! The arm of a page: a slider, the arm where it stands, its modes there.

use super::text;
use crate::study::arm::{Arm, MissingMesh};

/// What the slider of an arm goes along.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::report) enum Slider<'a> {
    /// The paths of operations with these names.
    Paths(&'a [&'a str]),
    /// The poses of a map.
    Poses,
}

/// The slider, the arm, and the modes where it stands; `index` is the place of the arm's data.
pub(in crate::report) fn controls(arm: &Arm, index: usize, slider: Slider) -> String {
    let heads = ["mode", "Hz", "interval Hz", "damping %", "tip µm/N"];
    let heads: String = heads.map(|name| format!("<th scope=\"col\">{name}</th>")).concat();
    let (title, place, select, key) = match slider {
        Slider::Paths(names) => {
            let option = |(place, name): (usize, &&str)| {
                format!("<option value=\"{place}\">{}</option>", text(name))
            };
            let options: String = names.iter().enumerate().map(option).collect();
            let select = format!(
                "<label>Operation <select data-is=\"operation\">{options}</select></label>"
            );
            ("Along the path", "Place", select, PATH_KEY)
        }
        Slider::Poses => ("The arm at the poses", "Pose", String::new(), ""),
    };
    format!(
        "<h2>{title}</h2>\n\
         <noscript><p>Without scripts the arm is not drawn; plots and tables stand \
         below.</p></noscript>\n\
         <div class=\"bar\">{select}<label class=\"grow\">{place} \
         <input type=\"range\" data-is=\"place\" min=\"0\" max=\"1\" value=\"0\"></label>\
         <output data-is=\"here\"></output></div>\n\
         <div class=\"arm\"><div><canvas data-is=\"view\" tabindex=\"0\" role=\"img\" \
         aria-label=\"The arm at the chosen place, moving in the chosen mode; drag or arrow keys \
         turn it, + and - zoom\"></canvas>\n\
         <p class=\"key\">{key}<span><i class=\"rest\"></i>arm at rest</span></p>{}</div>\n\
         <div><h3 data-is=\"mode\"></h3>\
         <p class=\"soft\">Amplitudes of the elastic coordinates, the largest as 1</p>\
         <div class=\"shape\" data-is=\"shape\"></div>\n\
         <div class=\"options\"><label><input type=\"checkbox\" data-is=\"animate\" checked> \
         move</label>\
         <label><input type=\"checkbox\" data-is=\"bodies\"> inertia ellipsoids</label>\
         <label>size <input type=\"range\" data-is=\"size\" min=\"1\" max=\"20\" \
         value=\"7\"></label></div>\n\
         <div class=\"scroll\"><table data-csv=\"modes\" data-is=\"modes\" \
         id=\"modes-{index}\"><thead>\
         <tr>{heads}</tr></thead><tbody></tbody></table></div></div></div>\n",
        not_drawn(arm)
    )
}

const PATH_KEY: &str = "<span><i class=\"resonance\"></i>path inside a band</span>\
     <span><i class=\"uncertain\"></i>within the doubt</span>\
     <span><i class=\"clear\"></i>clear</span>";

/// Which meshes are not drawn, and why.
fn not_drawn(arm: &Arm) -> String {
    if arm.missing_meshes.is_empty() {
        return String::new();
    }
    let one = |MissingMesh { link, file, why }: &MissingMesh| {
        format!("<li>{}</li>", text(&format!("{link}: {file}: {why}")))
    };
    let all: String = arm.missing_meshes.iter().map(one).collect();
    format!(
        "<details><summary>Meshes that are not drawn: {}</summary><ul>{all}</ul></details>",
        arm.missing_meshes.len()
    )
}
