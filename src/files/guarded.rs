//! The net behind which files of other programs are decoded: a panic of a decoder is an error of its file.
//!
//! Decoders are packages of others, and files may be damaged in ways that nobody thought of. The photo, model or layered
//! file is left out with an error that names it, and everything else goes on.

use std::any::Any;
use std::cell::RefCell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use quadratura_base::error::{Error, Message, Result};

/// The longest part of a panic's text that a message quotes, in characters.
const QUOTED: usize = 160;

thread_local! {
    /// The files that this thread is decoding, the innermost last; `None` for bytes that are no file of their own.
    static DECODING: RefCell<Vec<Option<Arc<Path>>>> = const { RefCell::new(Vec::new()) };
}

/// Runs the decoder of a file. A panic becomes an error about the file with this remedy.
///
/// # Errors
/// Those of the decoder; [`Error::Input`] where it panicked.
pub fn guarded<T>(file: &Path, remedy: impl Into<Message>, decode: impl FnOnce() -> Result<T>) -> Result<T> {
    caught(Some(file.into()), decode)
        .unwrap_or_else(|said| Err(Error::input(file, "", format!("its decoder failed ({said})"), remedy)))
}

/// Runs a decoder of bytes that are no file of their own, such as a colour profile. Returns what a panic said as an error.
///
/// # Errors
/// The text of the panic.
pub fn guarded_bytes<T>(decode: impl FnOnce() -> T) -> Result<T, String> {
    caught(None, decode)
}

/// Returns the file that this thread is decoding: what is decoded later, on request, belongs to it.
pub fn file_being_decoded() -> Option<PathBuf> {
    DECODING.with_borrow(|files| files.last().cloned().flatten().map(|file| file.to_path_buf()))
}

/// Returns true while this thread decodes something. A panic is reported as the file's error then, so the program's own
/// message about a fault would only mislead.
pub fn is_decoding() -> bool {
    // Thread-local storage may be gone in a thread that ends.
    DECODING.try_with(|files| files.try_borrow().is_ok_and(|files| !files.is_empty())).unwrap_or(false)
}

/// The only place where a decoder's panic is caught.
fn caught<T>(file: Option<Arc<Path>>, decode: impl FnOnce() -> T) -> Result<T, String> {
    struct Leave;
    impl Drop for Leave {
        fn drop(&mut self) {
            DECODING.with_borrow_mut(|files| files.pop());
        }
    }
    DECODING.with_borrow_mut(|files| files.push(file));
    let _leave = Leave;
    // Whatever the decoder was making is dropped with it.
    catch_unwind(AssertUnwindSafe(decode)).map_err(|panic| said(&*panic))
}

/// Returns the first line of a panic's text.
fn said(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or_default();
    match text.lines().next().unwrap_or_default() {
        "" => "it says nothing about why".to_owned(),
        line => line.chars().take(QUOTED).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_an_error_of_the_innermost_file_and_the_next_file_is_decoded() {
        let outer = guarded(Path::new("model.glb"), "export it again", || {
            assert!(is_decoding());
            let inner: Result<u32> = guarded(Path::new("leaf.png"), "save it again", || {
                assert_eq!(file_being_decoded(), Some("leaf.png".into()));
                let none: [u32; 0] = [];
                Ok(none[std::hint::black_box(3)])
            });
            let said = inner.unwrap_err().to_string();
            assert!(said.starts_with("leaf.png: its decoder failed (index out of bounds"), "{said}");
            assert!(said.ends_with("; save it again"), "{said}");
            assert_eq!(file_being_decoded(), Some("model.glb".into()));
            Ok(7)
        });
        assert_eq!(outer.unwrap(), 7);
        assert!(!is_decoding());
        assert_eq!(file_being_decoded(), None);
    }

    #[test]
    fn an_error_passes_as_it_is_and_bytes_have_no_name() {
        let error = guarded::<()>(Path::new("a"), "b", || Err(Error::Cancelled)).unwrap_err();
        assert!(matches!(error, Error::Cancelled));
        let said =
            guarded_bytes(|| assert!(std::hint::black_box(1) == 2, "not a profile\nat all")).unwrap_err();
        assert_eq!(said, "not a profile");
    }
}
