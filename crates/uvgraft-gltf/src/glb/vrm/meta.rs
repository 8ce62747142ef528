//! Metadata of an avatar: authors, licence and permissions.

use super::VrmError;
use super::json;

/// URL of VRM's own licence, whose terms the permissions fill in.
const LICENSE_URL: &str = "https://vrm.dev/licenses/1.0/";

/// Metadata of a VRM file. Authors and permissions have no default.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct VrmMeta {
    /// Name of the avatar.
    pub name: String,
    /// Authors, the responsible one first.
    pub authors: Vec<String>,
    /// What others may do with it.
    pub permissions: Permissions,
    /// Version of the avatar.
    pub version: Option<String>,
    /// Copyright holders.
    pub copyright: Option<String>,
    /// Contact information of the author.
    pub contact: Option<String>,
    /// Works that it is derived from.
    pub references: Vec<String>,
    /// Licences of third-party parts, such as body models.
    pub third_party_licenses: Option<String>,
    /// URL of further terms.
    pub other_license_url: Option<String>,
}

impl VrmMeta {
    /// Metadata with the required fields only.
    pub fn new(name: impl Into<String>, authors: Vec<String>, permissions: Permissions) -> Self {
        Self {
            name: name.into(),
            authors,
            permissions,
            version: None,
            copyright: None,
            contact: None,
            references: Vec::new(),
            third_party_licenses: None,
            other_license_url: None,
        }
    }

    pub(super) fn check(&self) -> Result<(), VrmError> {
        let blank = |text: &String| text.trim().is_empty();
        if blank(&self.name) {
            return Err(VrmError::Meta { problem: "must have a name" });
        }
        if self.authors.is_empty() || self.authors.iter().any(blank) {
            return Err(VrmError::Meta { problem: "must have an author" });
        }
        Ok(())
    }

    /// - `thumbnail`: index of an image.
    pub(super) fn json(&self, thumbnail: Option<usize>) -> json::Meta {
        let permissions = &self.permissions;
        json::Meta {
            name: self.name.clone(),
            version: self.version.clone(),
            authors: self.authors.clone(),
            copyright_information: self.copyright.clone(),
            contact_information: self.contact.clone(),
            references: self.references.clone(),
            third_party_licenses: self.third_party_licenses.clone(),
            thumbnail_image: thumbnail,
            license_url: LICENSE_URL,
            avatar_permission: permissions.avatar.name(),
            allow_excessively_violent_usage: permissions.violent,
            allow_excessively_sexual_usage: permissions.sexual,
            commercial_usage: permissions.commercial.name(),
            allow_political_or_religious_usage: permissions.political_or_religious,
            allow_antisocial_or_hate_usage: permissions.antisocial_or_hate,
            credit_notation: if permissions.credit { "required" } else { "unnecessary" },
            allow_redistribution: permissions.redistribution,
            modification: permissions.modification.name(),
            other_license_url: self.other_license_url.clone(),
        }
    }
}

macro_rules! named {
    ($(#[$doc:meta])* $kind:ident { $($(#[$variant_doc:meta])* $variant:ident $name:literal,)* }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub enum $kind {
            $($(#[$variant_doc])* $variant,)*
        }

        impl $kind {
            /// The identifier in VRM files.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)*
                }
            }

            /// The variant with this identifier.
            pub fn named(name: &str) -> Option<Self> {
                [$(Self::$variant,)*].into_iter().find(|known| known.name() == name)
            }
        }
    };
}

named! {
    /// Who may act as the avatar.
    AvatarPermission {
        /// The author alone.
        OnlyAuthor "onlyAuthor",
        /// People with an explicit licence.
        OnlySeparatelyLicensedPerson "onlySeparatelyLicensedPerson",
        /// Everyone.
        Everyone "everyone",
    }
}

named! {
    /// Who may use it commercially.
    CommercialUsage {
        /// Nobody; personal non-profit use only.
        PersonalNonProfit "personalNonProfit",
        /// Individuals.
        PersonalProfit "personalProfit",
        /// Individuals and companies.
        Corporation "corporation",
    }
}

named! {
    /// Whether it may be modified.
    Modification {
        /// It may not be modified.
        Prohibited "prohibited",
        /// It may be modified for one's own use.
        AllowModification "allowModification",
        /// It may be modified, and the result may be redistributed.
        AllowModificationRedistribution "allowModificationRedistribution",
    }
}

/// Permissions for others to use an avatar: the choices of VRM's licence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Permissions {
    /// Who may act as the avatar.
    pub avatar: AvatarPermission,
    /// Who may use it commercially.
    pub commercial: CommercialUsage,
    /// Whether it may be modified.
    pub modification: Modification,
    /// Whether it may be redistributed.
    pub redistribution: bool,
    /// Whether the author must be credited.
    pub credit: bool,
    /// Whether excessively violent use is allowed.
    pub violent: bool,
    /// Whether excessively sexual use is allowed.
    pub sexual: bool,
    /// Whether political or religious use is allowed.
    pub political_or_religious: bool,
    /// Whether antisocial or hateful use is allowed.
    pub antisocial_or_hate: bool,
}

impl Permissions {
    /// For the author only; nothing is allowed to others. These are VRM's defaults for omitted
    /// fields.
    pub const ONLY_AUTHOR: Self = Self {
        avatar: AvatarPermission::OnlyAuthor,
        commercial: CommercialUsage::PersonalNonProfit,
        modification: Modification::Prohibited,
        redistribution: false,
        credit: true,
        violent: false,
        sexual: false,
        political_or_religious: false,
        antisocial_or_hate: false,
    };

    /// Everyone may use, modify and redistribute it without profit, crediting the author.
    pub const NON_COMMERCIAL: Self = Self {
        avatar: AvatarPermission::Everyone,
        modification: Modification::AllowModificationRedistribution,
        redistribution: true,
        ..Self::ONLY_AUTHOR
    };

    /// As [`Self::NON_COMMERCIAL`], and commercial use is allowed.
    pub const EVERYONE: Self =
        Self { commercial: CommercialUsage::Corporation, ..Self::NON_COMMERCIAL };

    /// The named permission sets, for user interfaces.
    pub const NAMED: [(&'static str, Self); 3] = [
        ("only-author", Self::ONLY_AUTHOR),
        ("non-commercial", Self::NON_COMMERCIAL),
        ("everyone", Self::EVERYONE),
    ];

    /// The permission set with this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::NAMED.into_iter().find(|(known, _)| *known == name).map(|(_, set)| set)
    }
}
