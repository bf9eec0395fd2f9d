//! The files of the page, built into the binary.

/// One of the page's own scripts: name, type, content.
macro_rules! js {
    ($name:literal) => {
        (
            concat!("/", $name),
            "text/javascript; charset=utf-8",
            include_str!(concat!("../../assets/view/", $name)),
        )
    };
}

/// A file of a page: name, type, content.
pub type File = (&'static str, &'static str, &'static str);

/// Style sheet of all pages.
pub const STYLE: File = (
    "/view.css",
    "text/css; charset=utf-8",
    include_str!("../../assets/view/view.css"),
);
pub const ICON: File = (
    "/icon.svg",
    "image/svg+xml",
    include_str!("../../assets/view/icon.svg"),
);

/// Numbers as all pages show them.
pub const FORMAT: File = js!("format.js");

/// The files of the page of `view`.
pub const FILES: &[File] = &[
    (
        "/",
        "text/html; charset=utf-8",
        include_str!("../../assets/view/index.html"),
    ),
    STYLE,
    ICON,
    (
        "/uPlot.js",
        "text/javascript; charset=utf-8",
        include_str!("../../assets/uplot/uPlot.iife.min.js"),
    ),
    (
        "/uPlot.css",
        "text/css; charset=utf-8",
        include_str!("../../assets/uplot/uPlot.min.css"),
    ),
    js!("view.js"),
    js!("model.js"),
    js!("draw.js"),
    js!("plot.js"),
    js!("cursor.js"),
    js!("strips.js"),
    js!("history.js"),
    js!("spectrum.js"),
    js!("fit.js"),
    js!("panels.js"),
    js!("runs.js"),
    js!("scrub.js"),
    js!("recording.js"),
    js!("track.js"),
    js!("ports.js"),
    js!("overview.js"),
    js!("settings.js"),
    FORMAT,
    js!("save.js"),
];
