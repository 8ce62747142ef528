//! Whose avatar it is, and what others may do with it.

use super::VrmError;
use super::json;

/// Where VRM's own licence is, whose terms the permissions fill in.
const LICENSE_URL: &str = "https://vrm.dev/licenses/1.0/";

/// What a VRM file has to say about itself. Who made it and what is allowed has no default.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct VrmMeta {
    /// What the avatar is called.
    pub name: String,
    /// Who made it, the first being responsible.
    pub authors: Vec<String>,
    /// What others may do with it.
    pub permissions: Permissions,
    /// The version of the avatar.
    pub version: Option<String>,
    /// Who has rights in it.
    pub copyright: Option<String>,
    /// How to reach the author.
    pub contact: Option<String>,
    /// What it was made from.
    pub references: Vec<String>,
    /// Licences of what it was made from, such as those of body models.
    pub third_party_licenses: Option<String>,
    /// Where further terms are.
    pub other_license_url: Option<String>,
}

impl VrmMeta {
    /// With what every file must have.
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

    /// - `thumbnail`: the number of an image.
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
            /// VRM's name.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)*
                }
            }

            /// What VRM calls so.
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
        /// Those to whom a licence was given.
        OnlySeparatelyLicensedPerson "onlySeparatelyLicensedPerson",
        /// Everyone.
        Everyone "everyone",
    }
}

named! {
    /// Who may earn with it.
    CommercialUsage {
        /// Nobody.
        PersonalNonProfit "personalNonProfit",
        /// Persons.
        PersonalProfit "personalProfit",
        /// Companies too.
        Corporation "corporation",
    }
}

named! {
    /// Whether it may be changed.
    Modification {
        /// It may not.
        Prohibited "prohibited",
        /// It may, for one's own use.
        AllowModification "allowModification",
        /// It may, and the result may be given on.
        AllowModificationRedistribution "allowModificationRedistribution",
    }
}

/// What others may do with an avatar: the choices of VRM's licence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Permissions {
    /// Who may act as it.
    pub avatar: AvatarPermission,
    /// Who may earn with it.
    pub commercial: CommercialUsage,
    /// Whether it may be changed.
    pub modification: Modification,
    /// Whether it may be given on.
    pub redistribution: bool,
    /// Whether its author has to be named.
    pub credit: bool,
    /// Whether it may be shown in excessive violence.
    pub violent: bool,
    /// Whether it may be shown in excessively sexual scenes.
    pub sexual: bool,
    /// Whether it may stand for politics or religion.
    pub political_or_religious: bool,
    /// Whether it may be used against society or in hatred.
    pub antisocial_or_hate: bool,
}

impl Permissions {
    /// For the author alone, with nothing allowed to others: what VRM assumes where a file is silent.
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

    /// For everyone to use, change and give on without profit, naming the author.
    pub const NON_COMMERCIAL: Self = Self {
        avatar: AvatarPermission::Everyone,
        modification: Modification::AllowModificationRedistribution,
        redistribution: true,
        ..Self::ONLY_AUTHOR
    };

    /// As [`Self::NON_COMMERCIAL`], and to earn with.
    pub const EVERYONE: Self =
        Self { commercial: CommercialUsage::Corporation, ..Self::NON_COMMERCIAL };

    /// The sets that have names, for those who choose one.
    pub const NAMED: [(&'static str, Self); 3] = [
        ("only-author", Self::ONLY_AUTHOR),
        ("non-commercial", Self::NON_COMMERCIAL),
        ("everyone", Self::EVERYONE),
    ];

    /// The set with this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::NAMED.into_iter().find(|(known, _)| *known == name).map(|(_, set)| set)
    }
}
