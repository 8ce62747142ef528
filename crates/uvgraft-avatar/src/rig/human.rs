//! The humanoid bones of VRM 1.0.

macro_rules! bones {
    ($($(#[$doc:meta])* $bone:ident $name:literal $required:literal,)*) => {
        /// A humanoid bone of VRM 1.0. Left is the person's own left.
        ///
        /// # Source
        /// VRM 1.0, `humanoid.md`: the names, and which bones a file must have.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[expect(missing_docs, reason = "each is VRM's name")]
        pub enum HumanBone {
            $($bone,)*
        }

        impl HumanBone {
            /// All bones, from the hips outwards: parents come first.
            pub const ALL: &[Self] = &[$(Self::$bone,)*];

            /// VRM's name.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$bone => $name,)*
                }
            }

            /// Whether a VRM file must have it.
            pub const fn required(self) -> bool {
                match self {
                    $(Self::$bone => $required,)*
                }
            }

            /// The corresponding bone on the other side; bones on the midline map to themselves.
            pub fn mirrored(self) -> Self {
                let other = match self.name() {
                    name if name.starts_with("left") => name.replacen("left", "right", 1),
                    name if name.starts_with("right") => name.replacen("right", "left", 1),
                    _ => return self,
                };
                Self::ALL.iter().copied().find(|bone| bone.name() == other).unwrap_or(self)
            }
        }
    };
}

bones! {
    Hips "hips" true,
    Spine "spine" true,
    Chest "chest" false,
    UpperChest "upperChest" false,
    Neck "neck" false,
    Head "head" true,
    LeftEye "leftEye" false,
    RightEye "rightEye" false,
    Jaw "jaw" false,
    LeftUpperLeg "leftUpperLeg" true,
    LeftLowerLeg "leftLowerLeg" true,
    LeftFoot "leftFoot" true,
    LeftToes "leftToes" false,
    RightUpperLeg "rightUpperLeg" true,
    RightLowerLeg "rightLowerLeg" true,
    RightFoot "rightFoot" true,
    RightToes "rightToes" false,
    LeftShoulder "leftShoulder" false,
    LeftUpperArm "leftUpperArm" true,
    LeftLowerArm "leftLowerArm" true,
    LeftHand "leftHand" true,
    RightShoulder "rightShoulder" false,
    RightUpperArm "rightUpperArm" true,
    RightLowerArm "rightLowerArm" true,
    RightHand "rightHand" true,
    LeftThumbMetacarpal "leftThumbMetacarpal" false,
    LeftThumbProximal "leftThumbProximal" false,
    LeftThumbDistal "leftThumbDistal" false,
    LeftIndexProximal "leftIndexProximal" false,
    LeftIndexIntermediate "leftIndexIntermediate" false,
    LeftIndexDistal "leftIndexDistal" false,
    LeftMiddleProximal "leftMiddleProximal" false,
    LeftMiddleIntermediate "leftMiddleIntermediate" false,
    LeftMiddleDistal "leftMiddleDistal" false,
    LeftRingProximal "leftRingProximal" false,
    LeftRingIntermediate "leftRingIntermediate" false,
    LeftRingDistal "leftRingDistal" false,
    LeftLittleProximal "leftLittleProximal" false,
    LeftLittleIntermediate "leftLittleIntermediate" false,
    LeftLittleDistal "leftLittleDistal" false,
    RightThumbMetacarpal "rightThumbMetacarpal" false,
    RightThumbProximal "rightThumbProximal" false,
    RightThumbDistal "rightThumbDistal" false,
    RightIndexProximal "rightIndexProximal" false,
    RightIndexIntermediate "rightIndexIntermediate" false,
    RightIndexDistal "rightIndexDistal" false,
    RightMiddleProximal "rightMiddleProximal" false,
    RightMiddleIntermediate "rightMiddleIntermediate" false,
    RightMiddleDistal "rightMiddleDistal" false,
    RightRingProximal "rightRingProximal" false,
    RightRingIntermediate "rightRingIntermediate" false,
    RightRingDistal "rightRingDistal" false,
    RightLittleProximal "rightLittleProximal" false,
    RightLittleIntermediate "rightLittleIntermediate" false,
    RightLittleDistal "rightLittleDistal" false,
}

impl HumanBone {
    /// The bone with this VRM name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|bone| bone.name() == name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bones_match_vrm() {
        assert_eq!(HumanBone::ALL.len(), 55);
        assert_eq!(HumanBone::ALL.iter().filter(|bone| bone.required()).count(), 15);
        assert_eq!(HumanBone::named("leftRingDistal"), Some(HumanBone::LeftRingDistal));
        assert_eq!(HumanBone::named("LeftRingDistal"), None);
    }
}
