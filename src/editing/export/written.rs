//! Writes a layered document where nothing is overwritten that was changed since its export, whole or not at all.

use std::path::{Path, PathBuf};

use super::place::{self, ExportDestination};
use quadratura_base::error::{Error, Result};
use quadratura_document::export_record::{ExportFormat, ExportedFile};
use quadratura_files::atomic::AtomicFile;
use quadratura_files::hash::hash_file;
use quadratura_io::exports::{WrittenFiles, exported_file};
use quadratura_layered_files::folder::NewFolder;
use quadratura_layered_files::format::{FileFormat, format_of};
use quadratura_layered_files::{FormatFit, LayeredDocument};

/// Where a document is written, and as what.
pub struct DocumentPlace<'a> {
    /// The folder, which exists.
    pub out: &'a Path,
    /// The name of the photo, or what stands for it: files and folders are called by it.
    pub name: &'a str,
    /// The files of earlier exports, which are replaced where nobody has changed them.
    pub written: &'a WrittenFiles,
    /// The format.
    pub format: ExportFormat,
}

/// A document that was written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WrittenDocument {
    /// The file or folder.
    pub path: PathBuf,
    /// Files that were not overwritten, because they were changed since their export.
    pub spared: Vec<PathBuf>,
    /// The size in bytes of the file, or of all files in the folder.
    pub bytes: u64,
}

/// Writes the record of an export, which lists these files.
type RecordWriter<'a> = &'a dyn Fn(Vec<ExportedFile>) -> Result<()>;

impl DocumentPlace<'_> {
    /// Writes a document: a file of the format, or a folder that `fill` fills. Then, before either has its name, `record` writes the
    /// record: a file without a record would count as changed for ever.
    ///
    /// # Errors
    /// Returns [`Error::Request`] for a document that is too large for the format, [`Error::Io`], and the errors of the layers'
    /// sources, of `fill` and of `record`. No incomplete file remains.
    pub fn write(
        &self,
        document: &LayeredDocument,
        fill: &dyn Fn(&mut NewFolder) -> Result<()>,
        record: RecordWriter,
    ) -> Result<WrittenDocument> {
        match &format_of(self.format).file {
            Some(format) => self.write_file(document, format, record),
            None => self.write_folder(fill, record),
        }
    }

    /// Writes the first of the format's variants, or the next one if that turns out too large.
    fn write_file(
        &self,
        document: &LayeredDocument,
        format: &FileFormat,
        record: RecordWriter,
    ) -> Result<WrittenDocument> {
        for variant in (format.variants)(document) {
            let destination = self.find_destination(variant.extension)?;
            let mut file = AtomicFile::create(&destination.target)?;
            match (variant.write)(file.file(), &destination.target, document)? {
                FormatFit::Whole => return self.finish(file, variant.extension, record),
                FormatFit::TooLarge => (),
            }
        }
        Err(Error::Request(format!("{}: too large for this format", document.title)))
    }

    fn write_folder(
        &self,
        fill: &dyn Fn(&mut NewFolder) -> Result<()>,
        record: RecordWriter,
    ) -> Result<WrittenDocument> {
        let mut new = NewFolder::create(self.find_destination(place::FOLDER)?.target)?;
        fill(&mut new)?;
        let file = |name: &String| exported_file(new.path(), name);
        let mut files: Vec<_> = new.files().iter().map(file).collect::<Result<_>>()?;
        let sizes = new.files().iter().map(|name| size_of(&new.path().join(name)));
        let bytes = sizes.sum::<Result<u64>>()?;
        let ExportDestination { target, spared } = self.find_destination(place::FOLDER)?;
        new.redirect(&target);
        let home = name_of(&target);
        files.iter_mut().for_each(|file| file.name = format!("{home}/{}", file.name));
        record(files)?;
        new.commit()?;
        Ok(WrittenDocument { path: target, spared, bytes })
    }

    /// Returns the destination for a file with this extension.
    fn find_destination(&self, extension: &str) -> Result<ExportDestination> {
        place::find(self.out, self.name, extension, self.written)
    }

    /// Moves a complete file to its destination, which is determined again because someone may have saved there while the file was
    /// written.
    fn finish(&self, mut file: AtomicFile, extension: &str, record: RecordWriter) -> Result<WrittenDocument> {
        let ExportDestination { target, spared } = self.find_destination(extension)?;
        file.redirect(&target);
        let bytes = size_of(file.path())?;
        record(vec![ExportedFile { name: name_of(&target), hash: hash_file(file.path())? }])?;
        file.commit()?;
        Ok(WrittenDocument { path: target, spared, bytes })
    }
}

/// Returns the size of a file in bytes.
fn size_of(file: &Path) -> Result<u64> {
    Ok(file.metadata().map_err(Error::io(file, "read it"))?.len())
}

/// Returns the last component of a path.
fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}
