//! Options for the metadata of avatars.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use uvgraft_assembly::avatar::Metadata;
use uvgraft_gltf::glb::Permissions;

use crate::heading;

#[derive(clap::Args)]
#[command(next_help_heading = heading::METADATA)]
pub(super) struct MetaArgs {
    /// Name of the avatar [default: the output's file name]
    #[arg(long, value_name = "NAME")]
    title: Option<String>,
    /// Author of the avatar; repeatable, required for .vrm
    ///
    /// A .glb stores authors in asset.copyright and asset.extras.
    #[arg(long = "author", id = "author", value_name = "NAME")]
    authors: Vec<String>,
    /// What others may do with the avatar; required for .vrm
    #[arg(long, alias = "licence", value_name = "TERMS", value_parser = licenses())]
    license: Option<Permissions>,
    /// URL of further licence terms (.vrm only)
    #[arg(long, value_name = "URL")]
    license_url: Option<String>,
    /// Third-party content and its licences, such as the body model (.vrm only)
    #[arg(long, value_name = "TEXT")]
    made_from: Option<String>,
}

/// The names of sets of permissions, each with its meaning.
fn licenses() -> impl TypedValueParser<Value = Permissions> {
    PossibleValuesParser::new(Permissions::NAMED.map(|(name, permissions)| {
        PossibleValue::new(name).help(match permissions {
            Permissions::ONLY_AUTHOR => "Use by the author only",
            Permissions::NON_COMMERCIAL => {
                "Use, modification and redistribution by anyone, non-commercially, with credit"
            }
            _ => "As non-commercial, and commercial use too",
        })
    }))
    .map(|name| Permissions::named(&name).expect("a name that the parser lists"))
}

impl MetaArgs {
    pub(super) fn metadata(&self) -> Metadata {
        Metadata {
            title: self.title.clone(),
            authors: self.authors.clone(),
            license: self.license,
            license_url: self.license_url.clone(),
            made_from: self.made_from.clone(),
        }
    }
}
