//! What the process was started with and is lost once Rust runs: a closed standard output, in whose
//! place Rust opens `/dev/null`, where output would go without an error.

#[cfg(any(target_os = "linux", target_os = "android", target_vendor = "apple"))]
mod early {
    use std::io;
    use std::os::fd::AsFd;
    use std::sync::atomic::{AtomicBool, Ordering};

    /// The error of a file that is not open.
    const EBADF: i32 = 9;

    pub(super) static WAS_CLOSED: AtomicBool = AtomicBool::new(false);

    extern "C" fn look() {
        let error = io::stdout().as_fd().try_clone_to_owned().err();
        let is_closed = error.is_some_and(|error| error.raw_os_error() == Some(EBADF));
        WAS_CLOSED.store(is_closed, Ordering::Relaxed);
    }

    // The only place where the loader calls something before Rust does: no safe one is known. The
    // function allocates, and otherwise calls the system alone.
    #[allow(unsafe_code)]
    #[used]
    #[cfg_attr(target_vendor = "apple", unsafe(link_section = "__DATA,__mod_init_func"))]
    #[cfg_attr(not(target_vendor = "apple"), unsafe(link_section = ".init_array"))]
    static LOOK: extern "C" fn() = look;
}

/// Whether standard output was closed.
#[cfg(any(target_os = "linux", target_os = "android", target_vendor = "apple"))]
pub(super) fn without_output() -> bool {
    early::WAS_CLOSED.load(std::sync::atomic::Ordering::Relaxed)
}

#[cfg(not(any(target_os = "linux", target_os = "android", target_vendor = "apple")))]
pub(super) fn without_output() -> bool {
    false
}
