//! The guide: how to use detune, one page a subject. The pages are Markdown files in `src/guide`,
//! to be read here or wherever the repository is hosted.
//!
//! | page | contents |
//! |---|---|
//! | [`your_robot`] | from a URDF to a first verdict in ten minutes |
//! | [`jobs`] | the job file, verdicts, warnings |
//! | [`settings`] | what jobs share: robot, policy, accepted findings |
//! | [`programs`] | RAPID, KRL, Fanuc TP, APT/CL, G-code, Heidenhain: what is read, what is refused |
//! | [`robots`] | the robot file, and the robots that come with detune |
//! | [`ci`] | checks in continuous integration |
//! | [`advice`] | safe spindle speeds, schedules, other remedies |
//! | [`process`] | what the cut does: stability, deflection, coefficients |
//! | [`report`] | a job, diagnosis or session as a page to look at |
//! | [`maps`] | natural frequencies over poses |
//! | [`video`] | from a video of marks to records |
//! | [`identification`] | from records of vibration to modes |
//! | [`diagnosis`] | what the model gets wrong, and why |
//! | [`messages`] | every error and warning, and what to do |
//! | [`validation`] | what was tested, and the command that repeats it |
//! | [`performance`] | times, and how they were measured |
//! | [`library`] | detune from Rust |
//! | [`python`] | detune from Python |
//! | [`development`] | how to add a cause, a dialect, a format, a verb; how to release |

// Pages link to each other as files; the first definition of a link wins, so here they lead to
// modules. Only the documentation holds the pages: an edit of one builds nothing else anew.
macro_rules! pages {
    ($($page:ident)+) => { $(
        #[doc = "[jobs]: crate::guide::jobs"]
        #[doc = "[settings]: crate::guide::settings"]
        #[doc = "[programs]: crate::guide::programs"]
        #[doc = "[robots]: crate::guide::robots"]
        #[doc = "[your robot]: crate::guide::your_robot"]
        #[doc = "[ci]: crate::guide::ci"]
        #[doc = "[advice]: crate::guide::advice"]
        #[doc = "[process]: crate::guide::process"]
        #[doc = "[maps]: crate::guide::maps"]
        #[doc = "[report]: crate::guide::report"]
        #[doc = "[video]: crate::guide::video"]
        #[doc = "[identification]: crate::guide::identification"]
        #[doc = "[diagnosis]: crate::guide::diagnosis"]
        #[doc = "[messages]: crate::guide::messages"]
        #[doc = "[validation]: crate::guide::validation"]
        #[doc = "[performance]: crate::guide::performance"]
        #[doc = "[library]: crate::guide::library"]
        #[doc = "[python]: crate::guide::python"]
        #[doc = "[development]: crate::guide::development"]
        #[doc = ""]
        #[cfg_attr(doc, doc = include_str!(concat!(stringify!($page), ".md")))]
        pub mod $page {}
    )+ };
}

pages! {
    your_robot jobs settings programs robots ci advice process maps report video identification
    diagnosis messages validation performance library python development
}
