//! SHA-256, by which a content security policy names what a page may run.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use sha2::{Digest, Sha256};

/// The digest of a text in base 64, as a content security policy has it.
pub(super) fn sha256_base64(text: &str) -> String {
    STANDARD.encode(Sha256::digest(text.as_bytes()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Content Security Policy Level 3, section 8.3, its example of a hash.
    #[test]
    fn a_digest_is_written_as_the_standard_has_it() {
        let digest = sha256_base64("alert('Hello, world.');");
        assert_eq!(digest, "qznLcsROx4GACP2dm0UCKCzCG+HiZ1guq6ZZDob/Tng=");
    }
}
